"""A shard: up to 64 frames in one HDF5 file without time stamps, so that equal frames give equal bytes.

Datasets, n frames: `jpeg` (bytes of all pictures) with `jpeg_offset` (n + 1); `frame_index` (n); `camera_index` (n,
into the attribute `cameras`); `pose_world_camera` (n, 4, 4); `pose_world_robot` (n, 3: x, y in metres, yaw in radians);
`record` with `record_offset` (n + 1): one JSON object a frame with its labels and conditions; `scenario` with
`scenario_offset`: one JSON object for each scenario in the shard.
"""

import io
import itertools
from collections.abc import Sequence
from pathlib import Path

import h5py
import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.errors import InputError
from adc_bench.world.frame import Conditions, Frame, Label
from adc_bench.world.scenario import Scenario

Array = NDArray[np.float64]


class FrameRecord(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a shard says in JSON about a frame."""

    labels: tuple[Label, ...]
    conditions: Conditions


def encode_shard(frames: Sequence[Frame], cameras: Sequence[str], scenarios: Sequence[Scenario]) -> bytes:
    """Return the bytes of the HDF5 file that holds these frames."""
    records = [msgspec.json.encode(FrameRecord(labels=f.labels, conditions=f.conditions)) for f in frames]
    robots = [(f.pose_world_robot.x_m, f.pose_world_robot.y_m, f.pose_world_robot.yaw_rad) for f in frames]
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        file.attrs["cameras"] = np.array([name.encode() for name in cameras])
        _put_blobs(file, "jpeg", [frame.jpeg for frame in frames])
        file["frame_index"] = np.array([frame.index for frame in frames], dtype=np.int64)
        file["camera_index"] = np.array([list(cameras).index(frame.camera) for frame in frames], dtype=np.int64)
        file["pose_world_camera"] = np.array([frame.pose_world_camera.matrix() for frame in frames])
        file["pose_world_robot"] = np.array(robots)
        _put_blobs(file, "record", records)
        _put_blobs(file, "scenario", [msgspec.json.encode(scenario) for scenario in scenarios])
    return buffer.getvalue()


class Shard:
    """A shard opened for reading: everything but the pictures is in memory, no file stays open.

    Raises:
        InputError: the file is missing, is no HDF5 file, is damaged, or does not hold `frames` frames.
    """

    def __init__(self, path: Path, frames: int) -> None:
        self._path = path
        try:
            with h5py.File(path, "r") as file:
                self._read(file)
        except FileNotFoundError:
            raise damaged(path, "no such file") from None
        except (OSError, KeyError, ValueError, msgspec.MsgspecError) as error:
            raise damaged(path, f"not a readable shard: {error}") from None
        if len(self.records) != frames:
            raise damaged(path, f"{len(self.records)} frames", f"{frames} frames")

    def _read(self, file: h5py.File) -> None:
        cameras: list[str] = [name.decode() for name in file.attrs["cameras"]]
        self.cameras = [cameras[i] for i in file["camera_index"][:]]
        self.frame_index: NDArray[np.int64] = file["frame_index"][:]
        self.pose_world_camera: Array = file["pose_world_camera"][:]
        self.pose_world_robot: Array = file["pose_world_robot"][:]
        self.records = [msgspec.json.decode(blob, type=FrameRecord) for blob in _take_blobs(file, "record")]
        self.scenarios = [msgspec.json.decode(blob, type=Scenario) for blob in _take_blobs(file, "scenario")]
        # The pictures lie in the file as they are, so plain reads serve them, whatever forks or threads there are.
        self._jpeg_start = int(file["jpeg"].id.get_offset()) + file["jpeg_offset"][:]

    def jpeg(self, row: int) -> bytes:
        """Return the picture's bytes as delivered."""
        start, end = int(self._jpeg_start[row]), int(self._jpeg_start[row + 1])
        try:
            with self._path.open("rb") as file:
                file.seek(start)
                data = file.read(end - start)
        except OSError as error:
            raise damaged(self._path, error.strerror or "an unreadable file") from None
        if len(data) != end - start:
            raise damaged(self._path, "a truncated file")
        return data


def damaged(path: Path, found: str, wanted: str = "the file as it was written") -> InputError:
    """Return the error for a dataset's file that cannot be used."""
    return InputError(
        where=str(path), found=found, wanted=wanted, todo="copy the dataset again, or delete the file and render again"
    )


def _put_blobs(file: h5py.File, name: str, blobs: Sequence[bytes]) -> None:
    file[name] = np.frombuffer(b"".join(blobs), dtype=np.uint8)
    file[f"{name}_offset"] = np.cumsum([0, *(len(blob) for blob in blobs)], dtype=np.int64)


def _take_blobs(file: h5py.File, name: str) -> list[bytes]:
    data, offset = file[name][:].tobytes(), file[f"{name}_offset"][:]
    return [data[start:end] for start, end in itertools.pairwise(offset)]
