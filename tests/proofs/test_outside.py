"""Readers that know nothing of this project find in the exports what the dataset holds, and the same errors of poses.

`sh scripts/outside.sh` installs them: Ultralytics, WebDataset and evo, each in an environment of its own in `.peers/`.
"""

import json
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from adc_bench.dataset import FrameDataset, load_split
from adc_bench.dataset.export import FormatName, export_dataset
from adc_bench.evaluate.metrics import RPE_STEPS, localization
from adc_bench.generate import render_split
from adc_bench.world.categories import CATEGORIES

ROOT = Path(__file__).parents[2]
FACT = re.compile(r"^\t(.+?)\t(.+)$", re.MULTILINE)

pytestmark = pytest.mark.slow


def tool(reader: str, program: str) -> str:
    path = ROOT / ".peers" / reader / "bin" / program
    if not path.exists():
        pytest.skip(f"no .peers/{reader}: sh scripts/outside.sh makes it")
    return str(path)


def answer(words: list[str], home: Path) -> str:
    """Return what a program prints; its settings go to a home of its own, and it knows no network."""
    environment = {
        **os.environ,
        "HOME": str(home),
        "YOLO_CONFIG_DIR": str(home),
        "YOLO_OFFLINE": "true",
        "MPLBACKEND": "Agg",
    }
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def splits(tmp_path_factory: pytest.TempPathFactory) -> dict[str, FrameDataset]:
    root, counts = tmp_path_factory.mktemp("outside"), {"train": 48, "val": 24, "test": 16}
    for name, count in counts.items():
        render_split(load_split(name), root / name, count=count, size_px=(160, 120), frames_per_shard=20)
    return {name: FrameDataset(root / name) for name in counts}


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> FrameDataset:
    root = tmp_path_factory.mktemp("outside") / "drives"
    render_split(load_split("val"), root, kind="drives", count=1, size_px=(96, 72))
    return FrameDataset(root)


def dataset_of(kind: str, request: pytest.FixtureRequest) -> FrameDataset:
    """Return the frames or the drives of the validation split, made only where a test wants them."""
    found = request.getfixturevalue("drives" if kind == "drives" else "splits")
    dataset: FrameDataset = found["val"] if kind == "frames" else found
    return dataset


def test_ultralytics_finds_every_box(splits: dict[str, FrameDataset], tmp_path: Path) -> None:
    python = tool("ultralytics", "python")
    for dataset in splits.values():
        export_dataset(dataset, "yolo", tmp_path / "yolo")
    script = Path(__file__).parent / "outside" / "count_boxes.py"
    told = answer([python, str(script), str(tmp_path / "yolo" / "data.yaml")], tmp_path)
    found = json.loads(told.splitlines()[-1])
    assert list(found["names"].values()) == list(CATEGORIES)
    assert list(found["classes"]) == ["train", "val", "test"]
    for name, dataset in splits.items():
        labels = [[lb.category_id - 1 for lb in dataset.annotations(i) if not lb.ignore] for i in range(len(dataset))]
        assert sum(map(len, labels)) > 10
        assert found["classes"][name] == {f"{i:06d}.jpg": classes for i, classes in enumerate(labels)}


@pytest.mark.parametrize("kind", ["frames", "drives"])
def test_webdataset_finds_every_sample(kind: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    python, dataset = tool("webdataset", "python"), dataset_of(kind, request)
    export_dataset(dataset, "webdataset", tmp_path / "out")
    script = Path(__file__).parent / "outside" / "read_tars.py"
    tars = sorted(str(path) for path in (tmp_path / "out").glob("*.tar"))
    found = json.loads(answer([python, str(script), *tars], tmp_path))
    shape = [dataset.height_px, dataset.width_px, 3]
    counts = [len(dataset.annotations(i)) for i in range(len(dataset))]
    assert sum(counts) > 10
    assert found == {f"val_{i:06d}": [shape, count] for i, count in enumerate(counts)}


@pytest.mark.parametrize("format_name", ["tum", "kitti"])
@pytest.mark.parametrize("kind", ["frames", "drives"])
def test_evo_reads_the_trajectories(
    kind: str, format_name: FormatName, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    evo, dataset = tool("evo", "evo_traj"), dataset_of(kind, request)
    export_dataset(dataset, format_name, tmp_path / "out")
    files = sorted((tmp_path / "out").glob("*.tum" if format_name == "tum" else "poses/*.txt"))
    assert [path.stem for path in files] == [Path(name).stem for name in dataset.store.names("poses/*.tum")]
    for path in files:
        rows = np.loadtxt(path, ndmin=2)
        places = rows[:, 1:4] if format_name == "tum" else rows[:, [3, 7, 11]]
        told = dict(FACT.findall(answer([evo, format_name, str(path), "--full_check"], tmp_path)))
        assert int(told["nr. of poses"]) == len(rows) > 10
        length_m = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
        assert float(told["path length (m)"]) == pytest.approx(length_m, abs=1e-6)
        assert told["SE(3) conform"] == "yes"
        if format_name == "tum":
            assert told["quaternions"] == told["timestamps"] == "ok"
            assert float(told["duration (s)"]) == pytest.approx(rows[-1, 0] - rows[0, 0], abs=1e-6)


@pytest.fixture(scope="module")
def trajectories() -> np.ndarray:
    """A hundred pairs of a path and an estimate that strays from it, (100, 2, n, 3)."""
    rng = np.random.default_rng(0)
    steps = rng.normal((0.05, 0.0, 0.0), (0.02, 0.005, 0.05), (100, 200, 3))
    yaw_rad = np.cumsum(steps[..., 2], axis=1)
    turned = (steps[..., 0] + 1j * steps[..., 1]) * np.exp(1j * yaw_rad)
    place = np.cumsum(turned, axis=1) + rng.uniform(-5, 5, (100, 1))
    truth = np.stack([place.real, place.imag, yaw_rad], axis=2)
    strays = np.cumsum(rng.normal(0.0, (0.004, 0.004, 0.003), truth.shape), axis=1) + rng.normal(0.0, 0.1, (100, 1, 3))
    return np.stack([truth, truth + strays], axis=1)


def test_evo_finds_the_same_errors(trajectories: np.ndarray, tmp_path: Path) -> None:
    python = tool("evo", "python")
    np.save(tmp_path / "pairs.npy", trajectories)
    script = Path(__file__).parent / "outside" / "evo_errors.py"
    theirs = json.loads(answer([python, str(script), str(tmp_path / "pairs.npy"), str(RPE_STEPS)], tmp_path))
    assert len(theirs) == 100
    for (truth, estimate), found in zip(trajectories, theirs, strict=True):
        ours = localization(truth, estimate, None, truth[:, :2])
        assert ours.position_rmse_m == pytest.approx(found["ape"], abs=1e-9)
        assert ours.ate_rmse_m == pytest.approx(found["aligned_ape"], abs=1e-9)
        assert ours.rpe_rmse_m == pytest.approx(found["rpe_m"], abs=1e-9)
        assert ours.rpe_rmse_rad == pytest.approx(found["rpe_rad"], abs=1e-9)
