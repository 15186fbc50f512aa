"""The wheel works away from the checkout: splits, shaders and the rest of the data travel with it."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
        wheel.extractall(folder / "site")
    return folder / "site"


def run(unpacked: Path, cwd: Path, *words: str) -> subprocess.CompletedProcess[str]:
    code = "import adc_bench.cli.main as m; assert m.__file__.startswith({!r}), m.__file__; m.main()"
    return subprocess.run(
        [sys.executable, "-c", code.format(str(unpacked)), *words],
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": str(unpacked)},
        capture_output=True,
        text=True,
        check=False,
    )


def test_every_data_file_is_inside(unpacked: Path) -> None:
    package = {path.relative_to(ROOT) for path in (ROOT / "adc_bench").rglob("*") if path.is_file()}
    data = {path for path in package if path.suffix not in {".py", ".pyc"}}
    splits = {"adc_bench" / path.relative_to(ROOT) for path in (ROOT / "splits").rglob("*.toml")}
    assert len(data) > 1 and len(splits) > 3
    assert [str(path) for path in sorted(data | splits) if not (unpacked / path).exists()] == []


def test_it_renders_where_no_checkout_is(unpacked: Path, tmp_path: Path) -> None:
    done = run(unpacked, tmp_path, "render", "--split", "train", "--frames", "1", "--out", "one")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "one" / "annotations" / "instances.json").exists()


def test_it_finds_its_weights(unpacked: Path, tmp_path: Path) -> None:
    code = "from adc_bench.detector import shipped_weights; print(shipped_weights().exists())"
    environment = os.environ | {"PYTHONPATH": str(unpacked)}
    shipped = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert shipped.stdout.strip() == "True", shipped.stderr
