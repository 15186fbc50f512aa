"""The same command, however it is run or cut off, gives the same bytes; another command is refused."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import msgspec
import pytest

from adc_bench.cli.main import main
from adc_bench.dataset import FrameDataset, load_split
from adc_bench.errors import MachineError
from adc_bench.generate import Progress, render_split
from adc_bench.generate.plan import ShardTask
from adc_bench.generate.run import render_shard

VAL = load_split("val")
SIZE = (160, 120)


def _files(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six shards of four frames, made by this process."""
    root = tmp_path_factory.mktemp("generate") / "small"
    render_split(VAL, root, count=24, size_px=SIZE, frames_per_shard=4)
    return root


def _command(out: Path, *words: str, count: int = 24) -> list[str]:
    code = "from adc_bench.cli.main import main; main()"
    told = ["--split", "val", "--size", "160x120", "--frames", str(count), "--frames-per-shard", "4", "--json"]
    return [sys.executable, "-c", code, "render", "--out", str(out), *told, *words]


def _start(out: Path, *words: str) -> subprocess.Popen[str]:
    """Start a run in a process group of its own."""
    pipe = subprocess.PIPE
    return subprocess.Popen(_command(out, *words), stdout=pipe, stderr=pipe, text=True, start_new_session=True)


def _shards(out: Path) -> dict[str, int]:
    return {path.name: path.stat().st_ino for path in out.glob("shard-*.h5")}


def _wait_for_shards(run: subprocess.Popen[str], out: Path, count: int) -> None:
    while len(_shards(out)) < count:
        assert run.poll() is None, run.communicate()
        time.sleep(0.01)


def _finish(run: subprocess.Popen[str]) -> tuple[dict[str, Any], str]:
    """Wait for a run; return its report and what it warned of."""
    out, told = run.communicate(timeout=120)
    assert run.returncode == 0, told
    return json.loads(out), told


def test_two_workers_write_the_same_bytes(small: Path, tmp_path: Path) -> None:
    told: list[Progress] = []
    render_split(VAL, tmp_path / "a", count=24, size_px=SIZE, frames_per_shard=4, workers=2, progress=told.append)
    assert _files(tmp_path / "a") == _files(small)
    assert [(now.done, now.total, now.frames) for now in told] == [(k, 6, 4 * k) for k in range(7)]
    (work,) = told[-1].nodes.values()
    assert (work.shards, work.frames) == (6, 24) and "frames/s" in told[-1].text


def test_very_many_frames_have_no_json_of_their_own(
    small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("adc_bench.dataset.layout.COCO_FRAMES_MAX", 23)
    render_split(VAL, tmp_path / "a", count=24, size_px=SIZE, frames_per_shard=4)
    assert _files(small).keys() - _files(tmp_path / "a").keys() == {"annotations/instances.json"}
    with pytest.raises(SystemExit) as end:
        main(["dataset", "export", str(tmp_path / "a"), "--format", "coco", "--out", str(tmp_path / "b")])
    assert end.value.code in (0, None)
    exported = json.loads((tmp_path / "b" / "annotations" / "instances.json").read_bytes())
    assert [image["id"] for image in exported["images"]] == list(range(24))


@pytest.mark.usefixtures("ray_cluster")
def test_a_cluster_writes_the_same_bytes(small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    report, _ = _finish(_start(Path("a"), "--engine", "ray"))  # a relative path, and workers elsewhere
    assert _files(tmp_path / "a") == _files(small)
    nodes = report["this_run"]["nodes"]
    assert len(nodes) == 2 and sum(work["shards"] for work in nodes.values()) == 6


@pytest.mark.slow
def test_a_node_that_is_lost_in_mid_run_changes_no_byte(small: Path, tmp_path: Path, ray_cluster: Any) -> None:
    third = ray_cluster.add_node(num_cpus=1, object_store_memory=80 * 2**20)
    run = _start(tmp_path / "a", "--engine", "ray")
    _wait_for_shards(run, tmp_path / "a", 1)
    ray_cluster.remove_node(third, allow_graceful=False)
    _finish(run)
    assert _files(tmp_path / "a") == _files(small)


@pytest.mark.parametrize("shards", [1, *(pytest.param(count, marks=pytest.mark.slow) for count in (0, 2, 3, 4))])
def test_a_killed_run_is_taken_up_and_ends_in_the_same_bytes(small: Path, tmp_path: Path, shards: int) -> None:
    out = tmp_path / "killed"
    run = _start(out, "--workers", "2")
    while not (out / "dataset.toml").exists():
        time.sleep(0.01)
    _wait_for_shards(run, out, shards)
    time.sleep(random.random() * 0.2)
    os.killpg(run.pid, signal.SIGKILL)
    run.communicate()
    kept = _shards(out)
    (out / ".shard-00005.h5.0.tmp").write_bytes(b"half a shard")
    _finish(_start(out, "--workers", "2"))
    assert _files(out) == _files(small)
    assert len({name for name, inode in _shards(out).items() if kept.get(name) == inode}) >= len(kept) - 2


def test_a_worker_that_is_killed_is_replaced(small: Path, tmp_path: Path) -> None:
    out = tmp_path / "a"
    run = _start(out, "--workers", "2")
    _wait_for_shards(run, out, 1)
    children = Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split()
    workers = [int(pid) for pid in children if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    os.kill(workers[0], signal.SIGKILL)
    _, told = _finish(run)
    assert "a worker died of SIGKILL; its task" in told
    assert _files(out) == _files(small)


CUT_OFF = [
    ("--workers", "2"),
    *(pytest.param(w, marks=pytest.mark.slow) for w in (("--workers", "1"), ("--engine", "ray"))),
]


@pytest.mark.parametrize("words", CUT_OFF, ids=" ".join)
def test_ctrl_c_leaves_nothing_half_written(
    small: Path, tmp_path: Path, words: tuple[str, str], request: pytest.FixtureRequest
) -> None:
    if "ray" in words:
        request.getfixturevalue("ray_cluster")
    out = tmp_path / "a"
    run = _start(out, *words)
    _wait_for_shards(run, out, 2)
    os.killpg(run.pid, signal.SIGINT)
    assert run.communicate(timeout=60) == ("", "") and run.returncode == 130
    whole = _files(small)
    for name, data in _files(out).items():
        if name != "dataset.toml" and not name.startswith("receipts/"):
            assert whole[name] == data
    _finish(_start(out, *words))
    assert _files(out) == whole


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--frames", "20"), "count = 24"),
        (("--split", "train"), "split = val"),
        (("--size", "320x240"), "cameras = road 160x120, panel 160x120"),
        (("--frames-per-shard", "8"), "frames_per_shard = 4"),
        (("--depth",), "extras = none"),
    ],
)
def test_a_changed_configuration_is_refused_and_nothing_is_mixed(
    small: Path, words: tuple[str, ...], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = _files(small)
    with pytest.raises(SystemExit) as end:
        main([*_command(small)[3:], *words])
    block = capsys.readouterr().err
    assert end.value.code == 3 and told in block and "--overwrite" in block
    assert _files(small) == before


def test_a_node_with_other_software_refuses(small: Path) -> None:
    plan = FrameDataset(small).manifest.plan
    other = msgspec.structs.replace(plan, software={**plan.software, "renderer": "llvmpipe (LLVM 1.0.0, 64 bits)"})
    with pytest.raises(MachineError) as caught:
        render_shard(ShardTask(out=str(small), number=0, plan=other, salt=None))
    assert caught.value.where.startswith("node ") and "llvmpipe" in caught.value.found
    assert caught.value.wanted.startswith("renderer llvmpipe (LLVM 1.0.0, 64 bits), as where the run was started")


def test_a_node_that_does_not_see_the_folder_refuses(small: Path, tmp_path: Path) -> None:
    with pytest.raises(MachineError, match="write to a folder that all nodes share"):
        render_shard(ShardTask(out=str(tmp_path), number=0, plan=FrameDataset(small).manifest.plan, salt=None))
    assert _files(tmp_path) == {}


@pytest.mark.slow
def test_a_node_for_which_the_driver_compiles_other_code_refuses(tmp_path: Path, ray_cluster: Any) -> None:
    node = ray_cluster.add_node(num_cpus=4, object_store_memory=80 * 2**20, env_vars={"LP_NATIVE_VECTOR_WIDTH": "128"})
    run = _start(tmp_path / "a", "--engine", "ray")
    _, told = run.communicate(timeout=120)
    ray_cluster.remove_node(node)
    assert run.returncode == 4
    assert "where:      node " in told and "128 bits)" in told and "others give other bytes" in told
