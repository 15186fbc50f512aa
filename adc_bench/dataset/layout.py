"""The dataset folder: its file names, and `dataset.toml`, which says what made it.

dataset.toml  README.md  preview.jpg  shard-00000.h5 ...  poses/<camera>.tum, or poses/drive-00000.tum ...
annotations/instances.json (of frames)  receipts/ (until it is finished)
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import msgspec

from adc_bench.dataset.split import Split
from adc_bench.world.quality import Extra, Quality
from adc_bench.world.sensors import CameraMount

SCHEMA = 2
FRAMES_PER_SHARD = 256
COCO_FRAMES_MAX = 250_000  # one JSON of more frames than these is beyond what readers of COCO can load
MANIFEST = "dataset.toml"
CARD = "README.md"
CARD_PICTURE = "preview.jpg"
Kind = Literal["frames", "drives"]
COCO = "annotations/instances.json"
RECEIPTS = "receipts"


def shard_name(number: int) -> str:
    """Return the file name of a shard."""
    return f"shard-{number:05d}.h5"


def poses_name(camera: str) -> str:
    """Return the file name of a camera's true poses."""
    return f"poses/{camera}.tum"


def drive_poses_name(number: int) -> str:
    """Return the file name of a drive's true poses."""
    return f"poses/drive-{number:05d}.tum"


def receipt_name(number: int) -> str:
    """Return the file name of what tells that a shard is finished."""
    return f"{RECEIPTS}/shard-{number:05d}.toml"


class FileEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A finished file: its name, and what its bytes must be."""

    file: str
    size_bytes: int
    sha256: str


class ShardEntry(FileEntry, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A finished shard, and how many frames are in it."""

    frames: int


class DriveCounts(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How many drives, how long they took in the simulation, and how far the robot went."""

    drives: int
    simulated_s: float
    distance_m: float


class Summary(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a dataset holds, counted; `boxes` leaves out the `ignored` regions, only drives have `driving`."""

    frames: int
    scenarios: int
    size_bytes: int
    tunnel_frames: int
    ignored: int
    cameras: dict[str, int]
    light_levels: dict[str, int]
    boxes: dict[str, int]
    driving: DriveCounts | None = None


class AnyManifest(msgspec.Struct):
    """What every version of `dataset.toml` says."""

    schema: int


class Manifest(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`dataset.toml`. An unfinished dataset has neither summary nor shards nor files (annotations and poses)."""

    schema: int = SCHEMA
    kind: Kind = "frames"
    count: int  # of frames, or of drives
    frames_per_shard: int = FRAMES_PER_SHARD  # of drives, each is a shard
    split: Split
    split_sha256: str
    salt_sha256: str | None = None
    software: dict[str, str]
    cameras: tuple[CameraMount, ...]
    quality: Quality = "fast"
    extras: tuple[Extra, ...] = ()
    summary: Summary | None = None
    shards: tuple[ShardEntry, ...] = ()
    files: tuple[FileEntry, ...] = ()

    @property
    def plan(self) -> "Manifest":
        """What was wanted, without what came of it."""
        return msgspec.structs.replace(self, summary=None, shards=(), files=())

    @property
    def shards_sha256(self) -> str:
        """The digest of the finished shards' digests: of all pictures, labels and poses."""
        return hashlib.sha256("".join(entry.sha256 for entry in self.shards).encode()).hexdigest()

    @property
    def shard_count(self) -> int:
        """How many shards the frames or drives fill."""
        return self.count if self.kind == "drives" else -(-self.count // self.frames_per_shard)

    @property
    def has_coco(self) -> bool:
        """Whether the annotations lie beside the shards as COCO too: not of drives, nor of very many frames."""
        return self.kind == "frames" and self.count <= COCO_FRAMES_MAX

    def shard_frames(self, number: int) -> range:
        """Return the indices of the frames in a shard of a dataset of frames."""
        assert self.kind == "frames", "how many frames a drive has, only driving it tells"
        first = number * self.frames_per_shard
        return range(first, min(first + self.frames_per_shard, self.count))


def write_file(path: Path, data: bytes) -> None:
    """Write the bytes under a temporary name, then rename: the file is whole or absent."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(path.name + ".tmp")
    temporary.write_bytes(data)
    temporary.replace(path)


def to_toml(record: msgspec.Struct) -> bytes:
    """Return a record of scalars, lists, mappings and lists of records as TOML."""
    return ("\n".join(_table(msgspec.to_builtins(record), "")).strip() + "\n").encode()


def _table(values: Mapping[str, object], path: str) -> list[str]:
    """Return the lines of a table: its own keys, then the tables inside it."""
    own, inner = [], []
    for key, value in values.items():
        name = f"{path}.{key}" if path else key
        if isinstance(value, dict):
            inner += ["", f"[{name}]", *_table(value, name)]
        elif isinstance(value, (list, tuple)) and value and isinstance(value[0], dict):
            for item in value:
                inner += ["", f"[[{name}]]", *_table(item, name)]
        elif value is not None:
            # TOML writes strings, numbers, booleans and lists of them as JSON does.
            own.append(f"{key} = {json.dumps(value)}")
    return [*own, *inner]
