"""Exports: what stands in them, that equal datasets give equal bytes, and whose folders they may be written to."""

import contextlib
import hashlib
import io
import json
import os
import signal
import subprocess
import tarfile
from pathlib import Path

import msgspec
import numpy as np
import pytest
from pycocotools.coco import COCO
from torchvision.datasets import CocoDetection
from typer.testing import CliRunner

from adc_bench.cli.main import app
from adc_bench.dataset import FrameDataset, load_split
from adc_bench.dataset.drive_recipe import DriveRecipe
from adc_bench.dataset.drives import DriveDataset
from adc_bench.dataset.export import FORMATS, FormatName, export_dataset
from adc_bench.dataset.store import Store
from adc_bench.errors import InputError, MachineError, UsageError
from adc_bench.generate import render_split
from adc_bench.geometry import Pose3
from adc_bench.world.categories import CATEGORIES


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> DriveDataset:
    root = tmp_path_factory.mktemp("rendered") / "drives"
    split = msgspec.structs.replace(load_split("val"), drives=DriveRecipe(count=2, duration_s=(1.0, 1.5)))
    render_split(split, root, kind="drives", size_px=(96, 72))
    return DriveDataset(root)


@pytest.fixture(scope="module")
def dataset(rendered: Path) -> FrameDataset:
    return FrameDataset(rendered)


def digests(out: Path | str) -> dict[str, str]:
    store = Store(out)
    return {name: hashlib.sha256(store.read(name)).hexdigest() for name in store.names()}


def boxes(dataset: FrameDataset, *, ignored: bool) -> list[int]:
    """The number of labels of each picture."""
    labels = [dataset.annotations(i) for i in range(len(dataset))]
    return [sum(ignored or not label.ignore for label in of_picture) for of_picture in labels]


def test_coco_is_read_by_pycocotools(dataset: FrameDataset, tmp_path: Path) -> None:
    export_dataset(dataset, "coco", tmp_path)
    with contextlib.redirect_stdout(io.StringIO()):
        coco = COCO(str(tmp_path / "annotations" / "instances.json"))
    assert list(coco.imgs) == list(range(len(dataset)))
    assert [len(coco.getAnnIds(imgIds=[i])) for i in coco.imgs] == boxes(dataset, ignored=True)
    for i, image in coco.imgs.items():
        assert (tmp_path / "images" / image["file_name"]).read_bytes() == dataset.jpeg(i)
        found = coco.loadAnns(coco.getAnnIds(imgIds=[i]))
        for annotation, label in zip(found, dataset.annotations(i), strict=True):
            x, y, width, height = annotation["bbox"]
            assert (x, y, x + width, y + height) == pytest.approx(label.box_px, abs=2e-3)
            assert coco.annToMask(annotation).sum() == label.visible_px


def test_lossless_pictures_are_called_png(rendered: Path, tmp_path: Path) -> None:
    dataset = FrameDataset(rendered)
    mounts = [
        msgspec.structs.replace(mount, imaging=msgspec.structs.replace(mount.imaging, jpeg_quality=None))
        for mount in dataset.manifest.cameras
    ]
    dataset.manifest = msgspec.structs.replace(dataset.manifest, cameras=tuple(mounts))
    export_dataset(dataset, "coco", tmp_path)
    images = json.loads((tmp_path / "annotations" / "instances.json").read_bytes())["images"]
    assert images[3]["file_name"] == "000003.png" and (tmp_path / "images" / "000003.png").is_file()


def test_coco_is_read_by_torchvision(dataset: FrameDataset, tmp_path: Path) -> None:
    export_dataset(dataset, "coco", tmp_path)
    with contextlib.redirect_stdout(io.StringIO()):
        seen = CocoDetection(str(tmp_path / "images"), str(tmp_path / "annotations" / "instances.json"))
    assert len(seen) == len(dataset)
    assert [len(target) for _, target in seen] == boxes(dataset, ignored=True)
    assert seen[0][0].size == (dataset.width_px, dataset.height_px)


def test_yolo_holds_every_box_that_counts(dataset: FrameDataset, tmp_path: Path) -> None:
    export_dataset(dataset, "yolo", tmp_path)
    sides = np.array([dataset.width_px, dataset.height_px, dataset.width_px, dataset.height_px])
    for i in range(len(dataset)):
        assert (tmp_path / "images" / "val" / f"{i:06d}.jpg").read_bytes() == dataset.jpeg(i)
        text = (tmp_path / "labels" / "val" / f"{i:06d}.txt").read_text()
        rows = np.array([line.split() for line in text.splitlines()], dtype=np.float64).reshape(-1, 5)
        labels = [label for label in dataset.annotations(i) if not label.ignore]
        assert rows[:, 0].tolist() == [label.category_id - 1 for label in labels]
        centre, size = rows[:, 1:3], rows[:, 3:5]
        found = np.hstack([centre - size / 2, centre + size / 2]) * sides
        np.testing.assert_allclose(found, np.array([lb.box_px for lb in labels]).reshape(-1, 4), atol=1e-5)


def test_yolo_joins_splits_and_says_what_is_missing(dataset: FrameDataset, tmp_path: Path) -> None:
    assert export_dataset(dataset, "yolo", tmp_path).notes == (
        "Ultralytics wants train too: export such a dataset into the same folder",
    )
    assert "train:" not in (tmp_path / "data.yaml").read_text()
    assert export_dataset(dataset, "yolo", tmp_path, split="train").notes == ()
    text = (tmp_path / "data.yaml").read_text()
    assert text.startswith("train: images/train\nval: images/val\nnc: 21\nnames:\n  0: crosswalk\n")
    assert [line.split(": ")[1] for line in text.splitlines()[4:]] == list(CATEGORIES)
    assert len(list(tmp_path.glob("images/*/*.jpg"))) == 2 * len(dataset) == len(list(tmp_path.glob("labels/*/*.txt")))


def test_webdataset_holds_a_tar_for_each_shard(dataset: FrameDataset, tmp_path: Path) -> None:
    export_dataset(dataset, "webdataset", tmp_path)
    tars = sorted(tmp_path.glob("*.tar"))
    assert [path.name for path in tars] == [f"val-{k:06d}.tar" for k in range(len(dataset.manifest.shards))]
    i = 0
    for path in tars:
        with tarfile.open(path) as tar:
            members = tar.getmembers()
            assert {(entry.mtime, entry.uid, entry.gid, entry.uname) for entry in members} == {(0, 0, 0, "")}
            for picture, record in zip(members[::2], members[1::2], strict=True):
                assert (picture.name, record.name) == (f"val_{i:06d}.jpg", f"val_{i:06d}.json")
                assert tar.extractfile(picture).read() == dataset.jpeg(i)
                told, labels = json.load(tar.extractfile(record)), dataset.annotations(i)
                assert [entry["instance"] for entry in told["annotations"]] == [label.instance for label in labels]
                assert told["light_level"] == dataset.conditions(i).light_level
                assert told["pose_world_camera"][:3] == pytest.approx(dataset.pose_world_camera(i)[:3, 3])
                assert told["pose_world_robot"][2] == pytest.approx(dataset.pose_world_robot(i).yaw_rad)
                assert [line["name"] for line in told["lane_lines"]] == [ln.name for ln in dataset.lane_lines(i)]
                i += 1
    assert i == len(dataset)


def test_trajectories_are_the_cameras(dataset: FrameDataset, tmp_path: Path) -> None:
    export_dataset(dataset, "tum", tmp_path / "tum")
    export_dataset(dataset, "kitti", tmp_path / "kitti")
    for camera in ("road", "panel"):
        assert (tmp_path / "tum" / f"{camera}.tum").read_bytes() == dataset.store.read(f"poses/{camera}.tum")
        poses = np.loadtxt(tmp_path / "kitti" / "poses" / f"{camera}.txt", ndmin=2)
        numbers = np.loadtxt(tmp_path / "kitti" / "sequences" / camera / "times.txt", dtype=int, ndmin=1)
        assert [dataset.camera(i) for i in numbers] == [camera] * len(numbers)
        for number, figures in zip(numbers, poses, strict=True):
            np.testing.assert_allclose(figures.reshape(3, 4), dataset.pose_world_camera(number)[:3], atol=1e-8)


def test_drives_are_exported_with_their_times(drives: DriveDataset, tmp_path: Path) -> None:
    frames = drives.frames
    for name in FORMATS:
        export_dataset(frames, name, tmp_path / name)
    images = json.loads((tmp_path / "coco" / "annotations" / "instances.json").read_bytes())["images"]
    for k in range(len(drives)):
        for camera in ("road", "panel"):
            seen = drives.pictures(k, camera)
            assert [images[i]["time_s"] for i in seen.frame] == seen.time_s.tolist()
            assert {images[i]["camera"] for i in seen.frame} == {camera}
        truth, name = drives.drive(k).truth, f"drive-{k:05d}"
        tum = np.loadtxt(tmp_path / "tum" / f"{name}.tum")
        np.testing.assert_allclose(tum, np.column_stack([truth["time_s"], truth["pose_world_robot"]]), atol=1e-6)
        times = np.loadtxt(tmp_path / "kitti" / "sequences" / name / "times.txt")
        poses = np.loadtxt(tmp_path / "kitti" / "poses" / f"{name}.txt").reshape(-1, 3, 4)
        np.testing.assert_allclose(times, truth["time_s"], atol=1e-6)
        for pose, figures in zip(poses, truth["pose_world_robot"], strict=True):
            np.testing.assert_allclose(pose, Pose3.from_figures(figures).matrix()[:3], atol=1e-8)
    assert len(list(tmp_path.glob("webdataset/*.tar"))) == len(drives) == 2
    labels = [label for i in range(len(frames)) for label in frames.annotations(i)]
    rows = [path.read_text().splitlines() for path in tmp_path.glob("yolo/labels/val/*.txt")]
    assert len(rows) == len(frames) and sum(map(len, rows)) == sum(not label.ignore for label in labels) > 0


@pytest.mark.parametrize("name", FORMATS)
def test_equal_datasets_give_equal_bytes_here_and_at_an_address(
    dataset: FrameDataset, tmp_path: Path, name: FormatName
) -> None:
    told: list[tuple[int, int]] = []
    export_dataset(dataset, name, tmp_path / "one", progress=lambda done, total: told.append((done, total)))
    export_dataset(dataset, name, tmp_path / "other")
    export_dataset(dataset, name, f"memory://export-{name}")
    assert told[-1] == (len(dataset), len(dataset))
    assert digests(tmp_path / "one") == digests(tmp_path / "other") == digests(f"memory://export-{name}")
    again = digests(tmp_path / "one")
    export_dataset(dataset, name, tmp_path / "one")
    assert digests(tmp_path / "one") == again


@pytest.mark.parametrize("name", ["coco", "yolo", "webdataset"])
def test_an_export_that_was_killed_is_made_whole(dataset: FrameDataset, tmp_path: Path, name: FormatName) -> None:
    def die(done: int, _: int) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    child = os.fork()
    if child == 0:
        export_dataset(dataset, name, tmp_path / "killed", progress=die)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    assert "whole = false" in (tmp_path / "killed" / "export.toml").read_text()
    export_dataset(dataset, name, tmp_path / "killed")
    export_dataset(dataset, name, tmp_path / "whole")
    assert digests(tmp_path / "killed") == digests(tmp_path / "whole")
    assert "whole = true" in (tmp_path / "killed" / "export.toml").read_text()


def refusal(dataset: FrameDataset, name: FormatName, out: Path, split: str | None = None) -> str:
    before = digests(out) if out.is_dir() else {}
    with pytest.raises(InputError) as caught:
        export_dataset(dataset, name, out, split=split)
    assert out.is_file() or digests(out) == before
    return str(caught.value)


def test_folders_of_something_else_are_refused(dataset: FrameDataset, tmp_path: Path) -> None:
    export_dataset(dataset, "tum", tmp_path / "tum")
    assert "an export as tum" in refusal(dataset, "kitti", tmp_path / "tum")
    assert "the export of val" in refusal(dataset, "tum", tmp_path / "tum", split="other")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("keep me")
    assert "a folder with other files" in refusal(dataset, "tum", tmp_path / "mine")
    assert "a folder with other files" in refusal(dataset, "tum", Path(dataset.store.root))
    (tmp_path / "file").write_text("a file")
    assert "a folder to write to" in refusal(dataset, "tum", tmp_path / "file")


def test_another_dataset_of_that_name_is_refused(dataset: FrameDataset, tmp_path: Path) -> None:
    export_dataset(dataset, "yolo", tmp_path)
    mark = tmp_path / "export.toml"
    digest = hashlib.sha256(dataset.store.read("dataset.toml")).hexdigest()
    mark.write_text(mark.read_text().replace(digest, 64 * "0"))
    assert "another dataset's export as val" in refusal(dataset, "yolo", tmp_path)
    mark.write_text("format = 'yolo'\nparts = 3\n")
    assert "$.parts" in refusal(dataset, "yolo", tmp_path)


@pytest.mark.parametrize(
    ("name", "split", "wanted"),
    [("yolo", "tuesday", "one of train, val, test"), ("webdataset", "../up", "letters, figures, - and _")],
)
def test_names_that_have_no_place(
    dataset: FrameDataset, tmp_path: Path, name: FormatName, split: str, wanted: str
) -> None:
    with pytest.raises(UsageError, match=wanted):
        export_dataset(dataset, name, tmp_path / "out", split=split)
    assert not (tmp_path / "out").exists()


def test_the_command_tells_what_it_wrote(rendered: Path, tmp_path: Path) -> None:
    words = ["dataset", "export", str(rendered), "--format", "yolo", "--as", "train", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(app, words, catch_exceptions=False)
    assert result.exit_code == 0
    assert result.stdout == (
        f"{tmp_path / 'out'}: {len(FrameDataset(rendered))} pictures of train as yolo\n"
        "  Ultralytics wants val too: export such a dataset into the same folder\n"
    )


@pytest.mark.parametrize("name", ["coco", "yolo", "webdataset"])
def test_a_full_disk_is_told_and_room_lets_it_finish(
    dataset: FrameDataset, tmp_path: Path, small_disk: Path, name: FormatName
) -> None:
    out = small_disk / "out"
    with pytest.raises(MachineError) as caught:
        export_dataset(dataset, name, out)
    assert caught.value.found == "no space left on device" and str(out) in caught.value.where
    assert "whole = false" in (out / "export.toml").read_text()
    assert not [path for path in out.rglob("*") if path.name.startswith(".")]
    subprocess.run(["mount", "-o", "remount,size=16m", str(small_disk)], check=True)
    export_dataset(dataset, name, out)
    export_dataset(dataset, name, tmp_path / "whole")
    assert digests(out) == digests(tmp_path / "whole")
