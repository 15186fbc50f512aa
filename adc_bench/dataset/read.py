"""Reading a dataset folder: pictures, labels, poses and conditions by position."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.layout import COCO, FRAMES_PER_SHARD, MANIFEST, SCHEMA, Manifest, ShardEntry, shard_name
from adc_bench.dataset.shard import Shard, damaged
from adc_bench.errors import InputError
from adc_bench.geometry import Pose2
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Conditions, Label
from adc_bench.world.records import load_record
from adc_bench.world.scenario import Scenario

RENDER = "make one with: adc-bench render --split NAME --out DIR"


class FrameDataset:
    """A finished dataset, read lazily; safe to use in forked and spawned processes.

    Raises:
        InputError: the folder is missing, is no dataset, is unfinished, or a file of it is missing or damaged. Sizes
            are checked when opened, the inside of a shard when first read; `dataset check` compares digests.
    """

    categories = CATEGORIES

    def __init__(self, root: Path) -> None:
        self.root = root
        self.manifest = load_manifest(root)
        _check_whole(root, self.manifest)
        self.coco_path = root / COCO
        self.width_px = self.manifest.cameras[0].width_px
        self.height_px = self.manifest.cameras[0].height_px
        self.image_ids = list(range(self.manifest.frames))
        self._shards: dict[int, Shard] = {}

    def __len__(self) -> int:
        return self.manifest.frames

    def jpeg(self, i: int) -> bytes:
        """Return picture i as delivered."""
        shard, row = self._locate(i)
        return shard.jpeg(row)

    def picture(self, i: int) -> NDArray[np.uint8]:
        """Return picture i as rgb, (height, width, 3) uint8."""
        bgr = cv2.imdecode(np.frombuffer(self.jpeg(i), dtype=np.uint8), cv2.IMREAD_COLOR)
        if bgr is None or bgr.shape != (self.height_px, self.width_px, 3):
            raise damaged(
                self.root / shard_name(i // FRAMES_PER_SHARD), f"frame {i} is not a picture of the right size"
            )
        return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), dtype=np.uint8)

    def annotations(self, i: int) -> Sequence[Label]:
        """Return the labels of frame i, ignore regions among them."""
        shard, row = self._locate(i)
        return shard.records[row].labels

    def conditions(self, i: int) -> Conditions:
        """Return the circumstances of frame i."""
        shard, row = self._locate(i)
        return shard.records[row].conditions

    def camera(self, i: int) -> str:
        """Return the name of the camera that took frame i."""
        shard, row = self._locate(i)
        name: str = shard.cameras[row]
        return name

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
        name = shard.records[row].conditions.scenario
        return next(scenario for scenario in shard.scenarios if scenario.name == name)

    def _locate(self, i: int) -> tuple[Shard, int]:
        if not 0 <= i < len(self):
            raise IndexError(f"frame {i} of {len(self)}")
        number, row = divmod(i, FRAMES_PER_SHARD)
        if number not in self._shards:
            entry = self.manifest.shards[number]
            self._shards[number] = Shard(self.root / entry.file, entry.frames)
        return self._shards[number], row


def load_manifest(root: Path) -> Manifest:
    """Return `dataset.toml` of a folder, finished or not.

    Raises:
        InputError: there is no such folder, it is no dataset, or its file is broken or of another schema.
    """
    wanted = f"a dataset folder with {MANIFEST}"
    if not root.is_dir():
        raise InputError(where=str(root), found="no such folder", wanted=wanted, todo=RENDER)
    if not (root / MANIFEST).is_file():
        raise InputError(where=str(root), found=f"a folder without {MANIFEST}", wanted=wanted, todo=RENDER)
    manifest = load_record(root / MANIFEST, Manifest)
    if manifest.schema != SCHEMA:
        raise InputError(
            where=str(root / MANIFEST), found=f"schema {manifest.schema}", wanted=f"schema {SCHEMA}", todo=RENDER
        )
    return manifest


def _check_whole(root: Path, manifest: Manifest) -> None:
    if manifest.summary is None:
        raise InputError(
            where=str(root),
            found="an unfinished dataset",
            wanted="a finished one",
            todo=f"finish it with: adc-bench render --split {manifest.split.name} --out {root} (as it was begun)",
        )
    frames = [len(manifest.shard_frames(number)) for number in range(manifest.shard_count)]
    if [entry.frames for entry in manifest.shards] != frames:
        raise damaged(root / MANIFEST, "shards that do not add up", f"{manifest.frames} frames")
    for entry in manifest.shards:
        _check_size(root / entry.file, entry)
    if not (root / COCO).is_file():
        raise damaged(root / COCO, "no such file")


def _check_size(path: Path, entry: ShardEntry) -> None:
    size = path.stat().st_size if path.is_file() else None
    if size is None:
        raise damaged(path, "no such file", f"a shard of {entry.frames} frames")
    if size != entry.size_bytes:
        kind = "truncated" if size < entry.size_bytes else "too long"
        raise damaged(path, f"a {kind} file of {size} bytes", f"{entry.size_bytes} bytes")
