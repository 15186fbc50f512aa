"""What can go wrong with a dataset's files, put there on purpose: exit code, block of text, and what is left."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import h5py
import msgspec
import pytest

from adc_bench.cli.main import main
from adc_bench.dataset.layout import COCO, Manifest, ShardEntry, to_toml
from adc_bench.dataset.receipts import Receipt, plan_sha256
from adc_bench.world.records import load_record

FRAMES = ["--split", "val", "--frames", "10", "--size", "160x120", "--frames-per-shard", "4", "--workers", "1"]
SHARDS = ["shard-00000.h5", "shard-00001.h5", "shard-00002.h5"]
PROGRAM = [sys.executable, "-c", "from adc_bench.cli.main import main; main()"]


class Told(msgspec.Struct, frozen=True, kw_only=True):
    """How a command ended."""

    code: int
    where: str = ""
    found: str = ""
    wanted: str = ""
    todo: str = ""


def told(code: int, text: str) -> Told:
    """Return the parts of an error's block; no block at all if the command did its work."""
    names = {"where": "where", "found": "found", "wanted": "wanted", "what to do": "todo"}
    parts = {names[name]: words for name, words in re.findall(r"^  ([a-z ]+?): +(.+)$", text, re.M) if name in names}
    assert (code == 0) == (not parts), text
    assert "Traceback" not in text
    return Told(code=code, **parts)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> "Run":
    return Run(capsys)


class Run:
    """Runs commands in this process."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys

    def __call__(self, *words: str | Path) -> Told:
        with pytest.raises(SystemExit) as ended:
            main([str(word) for word in words])
        assert isinstance(ended.value.code, int)
        return told(ended.value.code, self._capsys.readouterr().err)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three shards of 4, 4 and 2 frames."""
    root = tmp_path_factory.mktemp("faults") / "whole"
    with pytest.raises(SystemExit, match="0"):
        main(["render", *FRAMES, "--out", str(root)])
    return root


@pytest.fixture
def damaged(whole: Path, tmp_path: Path) -> Path:
    """A copy of it, to be damaged."""
    return Path(shutil.copytree(whole, tmp_path / "damaged"))


def files(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


def begun_again(root: Path) -> Manifest:
    """Put a dataset back to where all shards and receipts are there and nothing else; return the plan."""
    finished = load_record(root / "dataset.toml", Manifest)
    shutil.rmtree(root / "annotations")
    shutil.rmtree(root / "poses")
    (root / "README.md").unlink()
    (root / "dataset.toml").write_bytes(to_toml(finished.plan))
    (root / "receipts").mkdir()
    for entry in finished.shards:
        put_receipt(root, finished.plan, entry)
    return finished.plan


def put_receipt(root: Path, plan: Manifest, entry: ShardEntry) -> None:
    name = entry.file.replace(".h5", ".toml")
    (root / "receipts" / name).write_bytes(to_toml(Receipt(plan_sha256=plan_sha256(plan), shard=entry)))


def test_a_full_disk_stops_the_run_and_room_lets_it_finish(small_disk: Path, whole: Path, run: Run) -> None:
    root = small_disk / "val"
    process = subprocess.run([*PROGRAM, "render", *FRAMES, "--out", str(root)], capture_output=True, text=True)
    error = told(process.returncode, process.stderr)
    assert error.code == 4 and error.found == "no space left on device"
    assert error.where.startswith(str(root)) and "make room" in error.todo and "resumes" in error.todo
    left = files(root)
    assert {name for name in left if name.endswith(".h5")} < set(SHARDS)
    assert all(data == (whole / name).read_bytes() for name, data in left.items() if name.endswith(".h5"))
    assert not [name for name in left if "/." in f"/{name}"]
    assert run("dataset", "check", root).found == "an unfinished dataset"
    subprocess.run(["mount", "-o", "remount,size=4m", str(small_disk)], check=True)
    assert run("render", *FRAMES, "--out", root).code == 0
    assert files(root) == files(whole)


def test_a_folder_that_cannot_be_written(small_disk: Path, run: Run) -> None:
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    error = run("render", *FRAMES, "--out", small_disk / "val")
    assert error.code == 4 and error.found == "read-only file system" and error.wanted == "permission to write there"
    assert str(small_disk) in error.where and "choose another folder" in error.todo


def test_two_processes_on_one_folder(tmp_path: Path, whole: Path, run: Run) -> None:
    root = tmp_path / "val"
    words = [*PROGRAM, "render", *FRAMES, "--frames", "400", "--out", str(root)]
    first = subprocess.Popen(words, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    while not (root / SHARDS[0]).exists():
        assert first.poll() is None
        time.sleep(0.02)
    for more in ([], ["--overwrite"]):
        error = run("render", *FRAMES, *more, "--out", root)
        assert error.code == 3 and error.where == str(root) and "wait until it has ended" in error.todo
        assert re.fullmatch(rf"process {first.pid} on \S+ is writing to this folder", error.found)
    first.kill()
    first.wait()
    error = run("render", *FRAMES, "--out", root)
    assert error.code == 3 and error.found == "a dataset of another run: count = 400" and error.wanted == "10"
    assert run("render", *FRAMES, "--overwrite", "--out", root).code == 0
    assert files(root) == files(whole)


def test_a_truncated_shard(damaged: Path, whole: Path, run: Run) -> None:
    shard = damaged / SHARDS[1]
    size = shard.stat().st_size
    os.truncate(shard, size // 2)
    error = run("dataset", "check", damaged)
    assert error == Told(
        code=3,
        where=str(shard),
        found=f"a truncated file of {size // 2} bytes",
        wanted=f"{size} bytes",
        todo="copy the dataset again, or delete the file and render again",
    )
    assert run("render", *FRAMES, "--out", damaged).code == 0
    assert files(damaged) == files(whole)


@pytest.mark.parametrize("finished", [True, False])
def test_a_flipped_byte_in_a_picture(damaged: Path, whole: Path, run: Run, finished: bool) -> None:
    if not finished:
        begun_again(damaged)
    shard = damaged / SHARDS[0]
    data = bytearray(shard.read_bytes())
    with h5py.File(shard) as file:
        data[file["jpeg"].id.get_offset() + 5000] ^= 1
    shard.write_bytes(data)
    if finished:
        error = run("dataset", "check", damaged)
        assert error.code == 3 and error.where == str(damaged)
        assert f"{SHARDS[0]}: other bytes than were written" in error.found and "render it again" in error.todo
    assert run("render", *FRAMES, "--out", damaged).code == 0
    assert files(damaged) == files(whole)


def test_a_picture_that_is_none_in_a_sound_shard(damaged: Path, run: Run) -> None:
    manifest = load_record(damaged / "dataset.toml", Manifest)
    with h5py.File(damaged / SHARDS[1], "a") as file:
        start, end = file["jpeg_offset"][2:4]
        file["jpeg"][start:end] = 0
    changed = list(manifest.shards)
    changed[1] = msgspec.structs.replace(changed[1], size_bytes=(damaged / SHARDS[1]).stat().st_size)
    (damaged / "dataset.toml").write_bytes(to_toml(msgspec.structs.replace(manifest, shards=tuple(changed))))
    check = subprocess.run([*PROGRAM, "dataset", "check", str(damaged)], capture_output=True, text=True)
    assert told(check.returncode, check.stderr).code == 3
    assert re.search(rf"{SHARDS[1]}.*2.*decoded", check.stdout), check.stdout


def test_a_shard_of_another_plan(damaged: Path, whole: Path, run: Run, tmp_path: Path) -> None:
    other = tmp_path / "other"
    assert run("render", *FRAMES, "--split", "train", "--out", other).code == 0
    shutil.copy(other / SHARDS[1], damaged / SHARDS[1])
    error = run("dataset", "check", damaged)
    assert error.code == 3 and error.where == str(damaged / SHARDS[1])
    begun_again(damaged)
    theirs = load_record(other / "dataset.toml", Manifest)
    put_receipt(damaged, theirs.plan, theirs.shards[1])
    (damaged / SHARDS[2]).write_bytes((damaged / SHARDS[0]).read_bytes())
    assert run("render", *FRAMES, "--out", damaged).code == 0
    assert files(damaged) == files(whole)


def test_a_shard_in_anothers_place_is_not_taken_even_with_a_receipt(damaged: Path, run: Run) -> None:
    plan = begun_again(damaged)
    (damaged / SHARDS[1]).write_bytes((damaged / SHARDS[0]).read_bytes())
    receipt = load_record(damaged / "receipts" / SHARDS[0].replace(".h5", ".toml"), Receipt).shard
    put_receipt(damaged, plan, msgspec.structs.replace(receipt, file=SHARDS[1]))
    error = run("render", *FRAMES, "--out", damaged)
    assert error.code == 3 and error.where == str(damaged / SHARDS[1])
    assert error.found == "frames from 0" and error.wanted == "the frames 4 to 7"
    assert not (damaged / COCO).exists()


@pytest.mark.parametrize("receipt", [b"", b"plan = 3", b"\xff\xfe"])
def test_a_broken_receipt_means_another_try(damaged: Path, whole: Path, run: Run, receipt: bytes) -> None:
    begun_again(damaged)
    (damaged / "receipts" / SHARDS[2].replace(".h5", ".toml")).write_bytes(receipt)
    assert run("render", *FRAMES, "--out", damaged).code == 0
    assert files(damaged) == files(whole)


def test_a_broken_manifest(damaged: Path, whole: Path, run: Run) -> None:
    text = (damaged / "dataset.toml").read_text()
    (damaged / "dataset.toml").write_text(text[: len(text) // 2] + '\nx = "')
    for words in (["dataset", "check", str(damaged)], ["render", *FRAMES, "--out", str(damaged)]):
        error = run(*words)
        assert error.code == 3 and error.where == str(damaged / "dataset.toml") and "broken TOML" in error.found
    assert set(files(damaged)) == set(files(whole))
    assert run("render", *FRAMES, "--overwrite", "--out", damaged).code == 0
    assert files(damaged) == files(whole)


@pytest.mark.parametrize("name", [COCO, "poses/road.tum"])
def test_annotations_that_are_gone(damaged: Path, whole: Path, run: Run, name: str) -> None:
    (damaged / name).unlink()
    error = run("dataset", "check", damaged)
    assert error.code == 3 and error.where == str(damaged / name) and error.found == "no such file"
    assert run("render", *FRAMES, "--out", damaged).code == 0
    assert files(damaged) == files(whole)


def test_finishing_that_was_cut_off_is_done_again(damaged: Path, whole: Path, run: Run) -> None:
    begun_again(damaged)
    (damaged / "annotations").mkdir()
    (damaged / "annotations" / ".instances.json.0123.tmp").write_bytes(b'{"info":')
    (damaged / "poses").mkdir()
    (damaged / "poses" / "road.tum").write_bytes(b"# of another time\n")
    assert run("render", *FRAMES, "--out", damaged).code == 0
    assert files(damaged) == files(whole)
