"""`dataset check`: silent about a sound dataset, and one sentence with its place for each fault put into it."""

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest
from amended import agree, amend
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from adc_bench.cli.main import app
from adc_bench.dataset import FrameDataset
from adc_bench.dataset.check import Looked, find_problems
from adc_bench.dataset.check.fingerprints import BITS, NEAR_BITS, NEAR_LEVELS, WORDS, fingerprint, near_pairs
from adc_bench.errors import InputError


def problems(folder: Path, **options: object) -> list[str]:
    return list(find_problems(FrameDataset(folder), **options))


def first_label(folder: Path, **wanted: object) -> int:
    """Return the number of the first label in the first shard with such a category id."""
    with h5py.File(folder / "shard-00000.h5") as file:
        return int(np.flatnonzero(file["labels/category_id"][:] == wanted["category_id"])[0])


def test_a_sound_dataset_has_no_problems(rendered: Path) -> None:
    looked, told = Looked(), []
    dataset = FrameDataset(rendered)
    found = find_problems(dataset, sample=50, looked=looked, progress=lambda done, total: told.append((done, total)))
    assert list(found) == []
    assert looked.frames == 70 and looked.labels == sum(len(dataset.annotations(i)) for i in range(70))
    assert looked.derived_again > 50 and told == [(1, 2), (2, 2)]


def put(index: object, value: object) -> Callable[[np.ndarray], None]:
    return lambda values: values.__setitem__(index, value)


def shift(index: object, by: float) -> Callable[[np.ndarray], None]:
    return lambda values: values.__setitem__(index, values[index] + by)


def turn(degrees: float) -> Callable[[np.ndarray], None]:
    def change(poses: np.ndarray) -> None:
        rotation, _ = cv2.Rodrigues(np.array([0.0, 0.0, np.radians(degrees)]))
        poses[3, :3, :3] = rotation @ poses[3, :3, :3]

    return change


FAULTS = {
    "labels/category_id": (put(0, 99), "its category is unknown"),
    "labels/box_px": (shift((0, 2), -1.0), "its box is not the one around its mask"),
    "labels/visible_px": (shift(0, 1), "pixels in its mask, visible_px"),
    "labels/amodal_box_px": (put((0, 0), -3.0), "its amodal box is empty or leaves the picture"),
    "labels/amodal_box_whole_px": (shift((slice(None), 0), -3.0), "its whole amodal box is 3.0 px off its projection"),
    "labels/visible_fraction": (put(0, 1.5), "its visible_fraction lies outside 0..1"),
    "labels/truncation": (put(0, np.nan), "its truncation lies outside 0..1"),
    "labels/distance_m": (put(0, -1.0), "its distance is not positive"),
    "labels/pose_world_object": (shift((slice(None), 0), 0.5), "it is not where its scenario puts it"),
    "labels/keypoints_px": (put((0, 0, 2), 7), "a keypoint's visibility is unknown"),
    "lane_lines/points_px": (shift(..., 2.0), "a point is 2.0 px off its projection"),
    "lane_lines/points_world": (shift(..., 0.1), "beside the line"),
    "pose_world_robot": (shift((3, 0), 0.1), "shard-00000.h5#3: the camera is 0.1"),
    "jpeg": (put(slice(0, 64), 0), "shard-00000.h5#0: its picture cannot be decoded"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_wrong_value_is_named(folder: Path, name: str) -> None:
    change, sentence = FAULTS[name]
    amend(folder, name, change)
    told = problems(folder)
    assert any(sentence in problem for problem in told), told[:5]
    assert all(problem.startswith(("shard-00000.h5", "annotations/instances.json")) for problem in told)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (turn(5.0), "the camera is turned by"),
        (put((3, 0, 0), np.nan), "a pose is not finite"),
        (shift((3, 1, 1), 0.01), "no rotation and translation"),
    ],
)
def test_a_wrong_camera_pose_is_named(folder: Path, change: Callable[[np.ndarray], None], sentence: str) -> None:
    amend(folder, "pose_world_camera", change)
    assert any(problem.startswith("shard-00000.h5#3: ") and sentence in problem for problem in problems(folder))


def test_a_keypoint_two_pixels_off_is_named(folder: Path) -> None:
    with h5py.File(folder / "shard-00000.h5") as file:
        seen = file["labels/keypoints_px"][:, :, 2] > 0
    label, corner = np.argwhere(seen)[0]
    amend(folder, "labels/keypoints_px", shift((label, corner, 0), 2.0))
    assert any(f"keypoint {corner} is 2.0 px off" in problem for problem in problems(folder))


def test_a_mask_of_another_object_is_named(folder: Path) -> None:
    """Give two labels of a frame each other's mask: of unlike lengths, so the offsets move too."""
    with h5py.File(folder / "shard-00000.h5", "r+") as file:
        group = file["labels"]
        first = int(group["offset"][:][np.argmax(np.diff(group["offset"][:]) > 1)])
        offset, data = group["mask_rle_offset"][:], group["mask_rle"][:]
        one, two = (data[offset[k] : offset[k + 1]] for k in (first, first + 1))
        data[offset[first] : offset[first + 2]] = np.concatenate([two, one])
        offset[first + 1] = offset[first] + len(two)
        group["mask_rle"][...], group["mask_rle_offset"][...] = data, offset
    agree(folder)
    assert any("its box is not the one around its mask" in problem for problem in problems(folder))


def test_a_picture_that_occurs_twice_is_named(folder: Path) -> None:
    with h5py.File(folder / "shard-00000.h5", "r+") as file:
        offset, data = file["jpeg_offset"][:], file["jpeg"][:]
        sizes = np.diff(offset)
        long, short = int(sizes.argmax()), int(sizes.argmin())
        picture = data[offset[short] : offset[short + 1]]
        data[offset[long] : offset[long + 1]] = np.pad(picture, (0, sizes[long] - len(picture)))
        file["jpeg"][...] = data
    agree(folder)
    first, second = (f"shard-00000.h5 frame {row}" for row in sorted((long, short)))
    told = [problem for problem in problems(folder) if "nearly the same picture" in problem]
    assert told == [f"{first} and {second}: nearly the same picture"]


def test_datasets_that_share_seeds_and_pictures(rendered: Path, folder: Path) -> None:
    dataset = FrameDataset(rendered)
    told = problems(folder, against=[dataset])
    seeds = len({dataset.scenario(i).seed for i in range(70)})
    assert told[0] == f"{rendered}: {seeds} of its scenarios have seeds of this dataset's"
    assert sum("nearly the same picture as" in problem for problem in told) == 70 and len(told) == 71


def coco_change(folder: Path, change: Callable[[dict], None]) -> list[str]:
    path = folder / "annotations" / "instances.json"
    lines = path.read_text().split("\n")
    document = json.loads("\n".join(lines))
    change(document)
    path.write_text(written_as_by_the_writer(document))
    agree(folder)
    return problems(folder, sample=0)


def written_as_by_the_writer(document: dict) -> str:
    parts = {name: ",\n".join(json.dumps(one) for one in document[name]) for name in ("images", "annotations")}
    return f'{{"images":[{parts["images"]}],"annotations":[{parts["annotations"]}]}}\n'


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda d: None, None),
        (lambda d: d["annotations"].pop(), "annotations for frame"),
        (lambda d: d["annotations"][0].update(category_id=21), "other categories or boxes than in its shard"),
        (lambda d: d["annotations"][0]["bbox"].__setitem__(2, 1.0), "other categories or boxes than in its shard"),
        (lambda d: d["images"].pop(), "its images are not the dataset's frames"),
        (lambda d: d["annotations"].append(d["annotations"][-1] | {"image_id": 999}), "of an image 999 that is none"),
        (lambda d: d["annotations"][0].pop("bbox"), "not the COCO file that was written"),
    ],
)
def test_coco_that_differs_is_named(folder: Path, change: Callable[[dict], None], sentence: str | None) -> None:
    told = coco_change(folder, change)
    if sentence is None:
        assert told == []
    else:
        assert len(told) == 1 and told[0].startswith("annotations/instances.json: ") and sentence in told[0]


def test_coco_that_is_cut_off_or_changed_is_named(folder: Path) -> None:
    path = folder / "annotations" / "instances.json"
    data = path.read_bytes()
    path.write_bytes(data.replace(b'"iscrowd":0', b'"iscrowd":1', 1))
    assert problems(folder, sample=0) == ["annotations/instances.json: other bytes than were written"]
    path.write_bytes(data[: len(data) // 2])
    agree(folder)
    assert "not the COCO file that was written" in problems(folder, sample=0)[0]


def test_a_flipped_byte_is_named(folder: Path) -> None:
    shard = folder / "shard-00001.h5"
    data = bytearray(shard.read_bytes())
    data[-1] ^= 0xFF
    shard.write_bytes(data)
    assert "shard-00001.h5: other bytes than were written" in problems(folder)


def test_the_command(folder: Path, rendered: Path) -> None:
    def run(*words: str | Path) -> str:
        return CliRunner().invoke(app, ["dataset", "check", *map(str, words)], catch_exceptions=False).stdout

    assert "70 frames and" in (told := run(folder)) and "of 70 frames derived again" in told
    assert json.loads(run(folder, "--json", "--sample", "0"))["derived_again"] == 0
    with pytest.raises(InputError, match="seeds of this dataset") as caught:
        run(folder, "--against", rendered)
    assert caught.value.exit_code == 3


sides = st.lists(st.binary(min_size=8 * WORDS, max_size=8 * WORDS), min_size=1, max_size=8)


@given(sides, sides, st.lists(st.integers(0, BITS - 1), max_size=20), st.integers(-8, 8))
def test_near_pairs_are_those_of_brute_force(
    first: list[bytes], second: list[bytes], flips: list[int], up: int
) -> None:
    twin = bytearray(first[0])
    for bit in flips:
        twin[bit // 8] ^= 1 << bit % 8
    twin[-1] = min(255, max(0, twin[-1] + up))
    first = [*first, bytes(twin)]

    def near(x: bytes, y: bytes) -> bool:
        bits = sum((p ^ q).bit_count() for p, q in zip(x[: BITS // 8], y[: BITS // 8], strict=True))
        levels = max(abs(p - q) for p, q in zip(x[BITS // 8 :], y[BITS // 8 :], strict=True))
        return bits <= NEAR_BITS and levels <= NEAR_LEVELS

    a, b = (np.array([np.frombuffer(one, np.uint64) for one in side]) for side in (first, second))
    within = {(i, j) for i in range(len(a)) for j in range(i + 1, len(a)) if near(first[i], first[j])}
    across = {(i, j) for i in range(len(a)) for j in range(len(b)) if near(first[i], second[j])}
    assert set(near_pairs(a)) == within and set(near_pairs(a, b)) == across


def test_altered_pictures_are_near_and_others_far(rendered: Path) -> None:
    dataset = FrameDataset(rendered)
    pictures = [dataset.picture(i) for i in range(len(dataset))]
    originals = np.array([fingerprint(picture) for picture in pictures])
    again = np.array([fingerprint(saved_again(picture)) for picture in pictures])
    near = {(i, j) for i, j in near_pairs(again, originals)}
    assert not list(near_pairs(originals))
    assert all(i == j for i, j in near) and len(near) >= 0.9 * len(pictures)


def saved_again(picture: np.ndarray) -> np.ndarray:
    _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 80])
    return cv2.imdecode(data, cv2.IMREAD_COLOR)
