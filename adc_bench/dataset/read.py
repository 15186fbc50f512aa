"""Reading a dataset folder: pictures, labels, poses and conditions by position."""

import itertools
from bisect import bisect_right
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.layout import MANIFEST, SCHEMA, AnyManifest, Manifest, ShardEntry
from adc_bench.dataset.shard import JpegIndex, Shard, damaged, read_jpeg_index
from adc_bench.dataset.store import Store
from adc_bench.errors import InputError
from adc_bench.geometry import Pose2
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Conditions, Label, LaneLine
from adc_bench.world.picture import decode_picture
from adc_bench.world.records import parse_record
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import CameraMount

FRAMES_IN_MEMORY = 32_768
RENDER = "make one with: adc-bench render --split NAME --out DIR"


class FrameDataset:
    """A finished dataset of frames or of drives, read lazily; safe to use in forked and spawned processes.

    Pictures are read straight from their place in the file. Labels and all else come a shard at a time, and are kept
    for the shards read last: FRAMES_IN_MEMORY frames at most, so memory does not grow with the dataset.

    Raises:
        InputError: the folder is missing, is no dataset, is unfinished, or a file of it is missing or damaged. Sizes
            are checked when opened, the inside of a shard when first read; `dataset check` compares digests.
        MachineError: the address wants a driver that is not installed, or does not answer.
    """

    categories = CATEGORIES

    def __init__(self, root: Path | str) -> None:
        self.store = Store(root)
        self.manifest = load_manifest(self.store)
        _check_whole(self.store, self.manifest)
        self._ends = list(itertools.accumulate(entry.frames for entry in self.manifest.shards))
        self.width_px = self.manifest.cameras[0].width_px
        self.height_px = self.manifest.cameras[0].height_px
        self.image_ids = range(len(self))
        self._jpegs: dict[int, JpegIndex] = {}
        self._shards: OrderedDict[int, Shard] = OrderedDict()
        largest = max(entry.frames for entry in self.manifest.shards)
        self._shards_most = max(1, FRAMES_IN_MEMORY // largest)

    def __len__(self) -> int:
        return self._ends[-1]

    def shards(self) -> Iterator[tuple[int, Shard]]:
        """Yield the number of its first frame and its content for each shard, in order, one in memory at a time."""
        for end, entry in zip(self._ends, self.manifest.shards, strict=True):
            yield end - entry.frames, Shard(self.store, entry.file, entry.frames)

    def jpeg(self, i: int) -> bytes:
        """Return picture i as delivered."""
        number, row = self._place(i)
        if number not in self._jpegs:
            entry = self.manifest.shards[number]
            self._jpegs[number] = read_jpeg_index(self.store, entry.file, entry.frames)
        return self._jpegs[number].read(row)

    def picture(self, i: int) -> NDArray[np.uint8]:
        """Return picture i as rgb, (height, width, 3) uint8."""
        rgb = decode_picture(self.jpeg(i))
        if rgb is None or rgb.shape != (self.height_px, self.width_px, 3):
            raise damaged(self.store.path(self.file(i)), f"frame {i} is not a picture of the right size")
        return rgb

    def annotations(self, i: int) -> Sequence[Label]:
        """Return the labels of frame i, ignore regions among them."""
        shard, row = self._locate(i)
        return shard.labels(row)

    def lane_lines(self, i: int) -> Sequence[LaneLine]:
        """Return the painted lines within frame i."""
        shard, row = self._locate(i)
        return shard.lane_lines(row)

    def depth_mm(self, i: int) -> NDArray[np.uint16] | None:
        """Return the distances along the camera's axis (h, w), 0 for unknown; None in a dataset without depth."""
        shard, row = self._locate(i)
        return shard.picture_row("depth_mm", row)

    def semantic(self, i: int) -> NDArray[np.uint8] | None:
        """Return the class of each pixel (h, w); None in a dataset without semantic masks."""
        shard, row = self._locate(i)
        return shard.picture_row("semantic", row)

    def conditions(self, i: int) -> Conditions:
        """Return the circumstances of frame i."""
        shard, row = self._locate(i)
        return shard.conditions(row)

    def camera(self, i: int) -> str:
        """Return the name of the camera that took frame i."""
        shard, row = self._locate(i)
        name: str = shard.cameras[row]
        return name

    def mount(self, i: int) -> CameraMount:
        """Return the camera that took frame i, as it is said to sit on the robot."""
        return next(mount for mount in self.manifest.cameras if mount.name == self.camera(i))

    def pose_world_robot(self, i: int) -> Pose2:
        """Return where the robot stood."""
        shard, row = self._locate(i)
        x_m, y_m, yaw_rad = (float(value) for value in shard.pose_world_robot[row])
        return Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw_rad)

    def pose_world_camera(self, i: int) -> NDArray[np.float64]:
        """Return where the camera (x right, y down, z forward) was, (4, 4)."""
        shard, row = self._locate(i)
        pose: NDArray[np.float64] = shard.pose_world_camera[row]
        return pose

    def scenario(self, i: int) -> Scenario:
        """Return the arena that frame i was taken in."""
        shard, row = self._locate(i)
        return shard.scenarios[shard.conditions(row).scenario]

    def file(self, i: int) -> str:
        """Return the name of the shard that holds frame i."""
        return self.manifest.shards[self._place(i)[0]].file

    def _place(self, i: int) -> tuple[int, int]:
        """Return the number of the shard that holds frame i, and the frame's row in it."""
        if not 0 <= i < len(self):
            raise IndexError(f"frame {i} of {len(self)}")
        number = bisect_right(self._ends, i)
        return number, i - (self._ends[number - 1] if number else 0)

    def _locate(self, i: int) -> tuple[Shard, int]:
        number, row = self._place(i)
        shard = self._shards.pop(number, None)
        if shard is None:
            entry = self.manifest.shards[number]
            shard = Shard(self.store, entry.file, entry.frames)
        self._shards[number] = shard
        while len(self._shards) > self._shards_most:
            self._shards.popitem(last=False)
        return shard, row


def load_manifest(store: Store) -> Manifest:
    """Return `dataset.toml` of a folder, finished or not.

    Raises:
        InputError: there is no such folder, it is no dataset, or its file is broken or of another schema.
    """
    if not store.exists(MANIFEST):
        raise InputError(
            where=store.path(""),
            found="an empty or missing folder" if store.is_empty() else f"no {MANIFEST}",
            wanted=f"a dataset folder with {MANIFEST}",
            todo=RENDER,
        )
    where = store.path(MANIFEST)
    schema = parse_record(store.read(MANIFEST), where, AnyManifest).schema
    if schema != SCHEMA:
        raise InputError(where=where, found=f"schema {schema}", wanted=f"schema {SCHEMA}", todo=RENDER)
    return parse_record(store.read(MANIFEST), where, Manifest)


def _check_whole(store: Store, manifest: Manifest) -> None:
    if manifest.summary is None:
        raise InputError(
            where=store.path(""),
            found="an unfinished dataset",
            wanted="a finished one",
            todo=f"finish it with: adc-bench render --split {manifest.split.name} --out {store.path('')} (as begun)",
        )
    if len(manifest.shards) != manifest.shard_count:
        raise damaged(store.path(MANIFEST), f"{len(manifest.shards)} shards", f"{manifest.shard_count} shards")
    sizes = store.sizes()
    for entry in manifest.shards:
        _check_size(store.path(entry.file), entry, sizes.get(entry.file))
    for described in manifest.files:
        if described.file not in sizes:
            raise damaged(store.path(described.file), "no such file")


def _check_size(path: str, entry: ShardEntry, size: int | None) -> None:
    if size is None:
        raise damaged(path, "no such file")
    if size != entry.size_bytes:
        kind = "truncated" if size < entry.size_bytes else "too long"
        raise damaged(path, f"a {kind} file of {size} bytes", f"{entry.size_bytes} bytes")
