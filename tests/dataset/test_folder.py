import hashlib
import multiprocessing
import os
import uuid
from pathlib import Path

import h5py
import msgspec
import numpy as np
import pytest

from adc_bench.dataset import FrameDataset, load_split, read
from adc_bench.dataset.check import find_problems
from adc_bench.dataset.layout import Manifest, to_toml
from adc_bench.dataset.sampling import scenario_number
from adc_bench.dataset.store import Store
from adc_bench.dataset.write import begin
from adc_bench.errors import InputError
from adc_bench.world.records import load_record


def _refusal(root: Path) -> str:
    with pytest.raises(InputError) as caught:
        dataset = FrameDataset(root)
        for i in range(len(dataset)):
            dataset.picture(i)
            dataset.annotations(i)
    assert caught.value.exit_code == 3
    return str(caught.value)


def _scenario(i: int) -> str:
    return f"val-{scenario_number(load_split('val'), i):05d}"


def test_frames_come_back(rendered: Path) -> None:
    dataset = FrameDataset(rendered)
    assert len(dataset) == 70 and list(dataset.image_ids) == list(range(70))
    for i in (0, 63, 64, 69):
        picture = dataset.picture(i)
        assert picture.shape == (240, 320, 3) and picture.dtype == np.uint8
        assert dataset.camera(i) == ("road", "panel")[i % 2]
        assert dataset.conditions(i).scenario == _scenario(i) == dataset.scenario(i).name
        assert dataset.pose_world_camera(i).shape == (4, 4)
    with pytest.raises(IndexError):
        dataset.picture(70)


def test_the_camera_stands_where_the_robot_carries_it(rendered: Path) -> None:
    dataset = FrameDataset(rendered)
    for i in range(len(dataset)):
        robot, camera = dataset.pose_world_robot(i), dataset.pose_world_camera(i)
        mount = dataset.scenario(i).rig.camera(dataset.camera(i))
        ahead = robot.inverse().transform(camera[None, :2, 3])[0]
        np.testing.assert_allclose([*ahead, camera[2, 3]], [mount.x_m, 0.0, mount.z_m], atol=0.03)


def test_a_sound_dataset_has_no_problems(rendered: Path) -> None:
    assert list(find_problems(FrameDataset(rendered))) == []


def test_manifest_says_what_made_it(rendered: Path) -> None:
    manifest = load_record(rendered / "dataset.toml", Manifest)
    assert manifest.split == load_split("val") and manifest.split_sha256 == manifest.split.sha256
    assert {"adc_bench", "sapien", "renderer"} <= set(manifest.software)
    for entry in manifest.shards:
        assert hashlib.sha256((rendered / entry.file).read_bytes()).hexdigest() == entry.sha256
    assert manifest.summary and manifest.summary.frames == 70 and set(manifest.summary.cameras) == {"road", "panel"}
    assert to_toml(manifest) == (rendered / "dataset.toml").read_bytes()
    card = (rendered / "README.md").read_text()
    assert manifest.split_sha256 in card and f"| crosswalk | {manifest.summary.boxes['crosswalk']} |" in card


def test_reading_goes_on_in_a_forked_process(rendered: Path) -> None:
    dataset = FrameDataset(rendered)
    expected = dataset.jpeg(1)
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.write(writing, hashlib.sha256(dataset.jpeg(1) + dataset.jpeg(65)).digest())
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    assert os.read(reading, 32) == hashlib.sha256(expected + dataset.jpeg(65)).digest()


def test_folders_that_are_no_datasets(tmp_path: Path, rendered: Path) -> None:
    assert "an empty or missing folder" in _refusal(tmp_path / "nowhere")
    assert "an empty or missing folder" in _refusal(tmp_path)
    plan = load_record(rendered / "dataset.toml", Manifest).plan
    begin(Store(tmp_path / "begun"), plan)
    assert "an unfinished dataset" in _refusal(tmp_path / "begun")
    assert "no dataset.toml" in _refusal(tmp_path)
    (tmp_path / "begun" / "dataset.toml").write_text("schema = 2\ncount = 'many'\n")
    assert "$.count" in _refusal(tmp_path / "begun")


def test_a_dataset_of_another_schema_is_refused(folder: Path) -> None:
    path = folder / "dataset.toml"
    path.write_text(path.read_text().replace("schema = 2", "schema = 99"))
    assert "schema 99" in _refusal(folder)


def test_a_truncated_shard_is_named(folder: Path) -> None:
    shard = folder / "shard-00001.h5"
    size = shard.stat().st_size
    os.truncate(shard, size // 2)
    told = _refusal(folder)
    assert f"a truncated file of {size // 2} bytes" in told and str(shard) in told and f"{size} bytes" in told


def test_a_missing_shard_is_named(folder: Path) -> None:
    (folder / "shard-00000.h5").unlink()
    assert "shard-00000.h5" in (told := _refusal(folder)) and "no such file" in told


def test_missing_annotations_are_named(folder: Path) -> None:
    (folder / "annotations" / "instances.json").unlink()
    assert "instances.json" in _refusal(folder)


def _replace_shard(folder: Path, number: int, data: bytes) -> None:
    """Put other bytes in a shard's place, and let the manifest agree on their size."""
    path = folder / "dataset.toml"
    manifest = load_record(path, Manifest)
    shards = list(manifest.shards)
    shards[number] = msgspec.structs.replace(shards[number], size_bytes=len(data))
    (folder / shards[number].file).write_bytes(data)
    path.write_bytes(to_toml(msgspec.structs.replace(manifest, shards=tuple(shards))))


def test_a_shard_that_is_no_hdf5_is_named(folder: Path) -> None:
    _replace_shard(folder, 1, b"no HDF5 at all" * 100)
    assert "shard-00001.h5" in (told := _refusal(folder)) and "not a readable shard" in told


def test_a_shard_that_lacks_a_part_is_named(folder: Path) -> None:
    with h5py.File(folder / "shard-00001.h5", "a") as file:
        del file["labels"]
    _replace_shard(folder, 1, (folder / "shard-00001.h5").read_bytes())
    assert "not a readable shard" in _refusal(folder)


def test_a_shard_with_too_few_frames_is_named(folder: Path) -> None:
    _replace_shard(folder, 0, (folder / "shard-00001.h5").read_bytes())
    assert "6 frames" in (told := _refusal(folder)) and "64 frames" in told


def test_check_finds_a_flipped_byte_and_a_lost_annotation(folder: Path) -> None:
    shard = folder / "shard-00000.h5"
    data = bytearray(shard.read_bytes())
    data[len(data) // 2] ^= 0xFF
    shard.write_bytes(data)
    coco = folder / "annotations" / "instances.json"
    lines = coco.read_bytes().splitlines(keepends=True)
    coco.write_bytes(b"".join([*lines[:-2], lines[-1]]))
    told = "\n".join(find_problems(FrameDataset(folder)))
    assert "shard-00000.h5: other bytes than were written" in told
    assert "annotations/instances.json: other bytes than were written" in told


def test_memory_holds_the_shards_read_last(rendered: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []

    class Counted(read.Shard):
        def __init__(self, store: Store, name: str, frames: int) -> None:
            opened.append(name)
            super().__init__(store, name, frames)

    monkeypatch.setattr(read, "Shard", Counted)
    monkeypatch.setattr(read, "FRAMES_IN_MEMORY", 64)
    dataset = FrameDataset(rendered)
    for i in (0, 63, 5, 64, 69, 0):
        assert dataset.conditions(i).scenario == _scenario(i)
    assert opened == ["shard-00000.h5", "shard-00001.h5", "shard-00000.h5"]
    opened.clear()
    assert len(dataset.jpeg(64)) > 1000 and not opened
    assert [first for first, _ in dataset.shards()] == [0, 64] and len(opened) == 2


def test_reading_goes_on_in_a_spawned_process(rendered: Path) -> None:
    dataset = FrameDataset(rendered)
    labels = dataset.annotations(65)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(dataset.jpeg, (65,)) == dataset.jpeg(65)
        assert pool.apply(dataset.annotations, (65,)) == labels


def test_a_dataset_in_a_store_of_objects_reads_the_same(rendered: Path) -> None:
    address = f"memory://{uuid.uuid4().hex}/val"
    store = Store(address)
    for path in rendered.rglob("*"):
        if path.is_file():
            store.write(str(path.relative_to(rendered)), path.read_bytes())
    here, there = FrameDataset(rendered), FrameDataset(address)
    for i in (0, 40, 69):
        assert there.jpeg(i) == here.jpeg(i) and there.annotations(i) == here.annotations(i)
        assert there.scenario(i) == here.scenario(i)
    assert list(find_problems(there)) == []
