"""A shard: up to some hundred frames in one HDF5 file without time stamps, so that equal frames give equal bytes.

The file's parts, n frames: `frame_index` (n); `jpeg` (bytes of all pictures) with `jpeg_offset` (n + 1); `camera_index`
(n, into the attribute `cameras`); `pose_world_camera` (n, 4, 4); `pose_world_robot` (n, 3: x, y in metres, yaw in
radians); `motion` (n, 2: m/s, rad/s); the groups `conditions`, `labels` and `lane_lines` (see `columns.py`); `scenario`
with `scenario_offset`: one JSON object for each arena in the shard. Where asked for, `depth_mm` (n, h, w) uint16, 0 for
nothing within its range, and `semantic` (n, h, w) uint8.
"""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property

import h5py
import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.columns import (
    Columns,
    conditions_at,
    labels_at,
    lane_lines_at,
    put_array,
    put_blobs,
    put_conditions,
    put_labels,
    put_lane_lines,
    take_blobs,
    take_conditions,
    take_labels,
    take_lane_lines,
)
from adc_bench.dataset.store import Store
from adc_bench.errors import InputError
from adc_bench.world.frame import Conditions, Frame, Label, LaneLine
from adc_bench.world.scenario import Scenario

Array = NDArray[np.float64]


def encode_shard(frames: Sequence[Frame], cameras: Sequence[str], scenarios: Sequence[Scenario]) -> bytes:
    """Return the bytes of the HDF5 file that holds these frames."""
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        put_frames(file, frames, cameras, scenarios)
    return buffer.getvalue()


def put_frames(file: h5py.File, frames: Sequence[Frame], cameras: Sequence[str], scenarios: Sequence[Scenario]) -> None:
    """Write the frames' parts into an open file."""
    robots = [(f.pose_world_robot.x_m, f.pose_world_robot.y_m, f.pose_world_robot.yaw_rad) for f in frames]
    file.attrs["cameras"] = np.array([name.encode() for name in cameras])
    put_blobs(file, "jpeg", [frame.jpeg for frame in frames])
    file["frame_index"] = np.array([frame.index for frame in frames], dtype=np.int64)
    file["camera_index"] = np.array([list(cameras).index(frame.camera) for frame in frames], dtype=np.int64)
    put_array(file, "pose_world_camera", np.array([frame.pose_world_camera.matrix() for frame in frames]))
    put_array(file, "pose_world_robot", np.array(robots))
    put_array(file, "motion", np.array([(frame.motion.v_mps, frame.motion.omega_radps) for frame in frames]))
    put_conditions(file.create_group("conditions"), [frame.conditions for frame in frames])
    put_labels(file.create_group("labels"), [frame.labels for frame in frames])
    put_lane_lines(file.create_group("lane_lines"), [frame.lane_lines for frame in frames])
    put_blobs(file, "scenario", [msgspec.json.encode(scenario) for scenario in scenarios])
    _put_pictures(file, frames)


def _put_pictures(file: h5py.File, frames: Sequence[Frame]) -> None:
    depths = [frame.depth_m for frame in frames if frame.depth_m is not None]
    semantics = [frame.semantic for frame in frames if frame.semantic is not None]
    if depths:
        millimetres = np.rint(np.stack(depths) * 1000)
        depth_mm = np.where(millimetres <= np.iinfo(np.uint16).max, millimetres, 0).astype(np.uint16)
        _put_stack(file, "depth_mm", depth_mm)
    if semantics:
        _put_stack(file, "semantic", np.stack(semantics))


def _put_stack(file: h5py.File, name: str, stack: NDArray[np.unsignedinteger]) -> None:
    """Write pictures (n, h, w), each a chunk of its own."""
    file.create_dataset(name, data=stack, chunks=(1, *stack.shape[1:]), compression="gzip", compression_opts=1)


@contextmanager
def open_shard(store: Store, name: str) -> Iterator[h5py.File]:
    """Give a shard's HDF5 file, opened for reading.

    Raises:
        InputError: it is missing, is no HDF5 file, or what is read meanwhile is damaged or not in it.
    """
    path = store.path(name)
    try:
        with store.open(name) as stream, h5py.File(stream, "r") as file:
            yield file
    except FileNotFoundError:
        raise damaged(path, "no such file") from None
    except (OSError, KeyError, ValueError, RuntimeError, msgspec.MsgspecError) as error:
        raise damaged(path, f"not a readable shard: {error}") from None


class JpegIndex:
    """Where a shard's pictures lie in its file, which is all that reading them needs: n + 1 numbers in memory.

    The pictures lie there as they are, so plain reads serve them, whatever forks or threads there are.
    """

    def __init__(self, store: Store, name: str, file: h5py.File) -> None:
        self._store, self._name = store, name
        self._starts: NDArray[np.int64] = int(file["jpeg"].id.get_offset() or 0) + file["jpeg_offset"][:]

    def __len__(self) -> int:
        return len(self._starts) - 1

    def read(self, row: int) -> bytes:
        """Return a picture's bytes as delivered."""
        start, end = self._starts[row : row + 2].tolist()
        try:
            data = self._store.read(self._name, start, end)
        except OSError as error:
            raise damaged(self._store.path(self._name), error.strerror or "an unreadable file") from None
        if len(data) != end - start:
            raise damaged(self._store.path(self._name), "a truncated file")
        return data


def read_jpeg_index(store: Store, name: str, frames: int) -> JpegIndex:
    """Return where a shard's pictures lie.

    Raises:
        InputError: as `open_shard`, or the shard does not hold `frames` frames.
    """
    with open_shard(store, name) as file:
        index = JpegIndex(store, name, file)
    _check_count(store.path(name), len(index), frames)
    return index


class Shard:
    """A shard read: all but pictures, lane lines and arenas is in memory, no file stays open.

    Raises:
        InputError: as `open_shard`, or the shard does not hold `frames` frames.
    """

    def __init__(self, store: Store, name: str, frames: int) -> None:
        self._store, self._name = store, name
        with open_shard(store, name) as file:
            self._read(file)
        _check_count(store.path(name), len(self.frame_index), frames)

    def _read(self, file: h5py.File) -> None:
        cameras: list[str] = [name.decode() for name in file.attrs["cameras"]]
        self.cameras = [cameras[i] for i in file["camera_index"][:]]
        self.frame_index: NDArray[np.int64] = file["frame_index"][:]
        self.pose_world_camera: Array = file["pose_world_camera"][:]
        self.pose_world_robot: Array = file["pose_world_robot"][:]
        self.motion: Array = file["motion"][:]
        self.condition_columns: Columns = take_conditions(file["conditions"])
        self.label_columns: Columns = take_labels(file["labels"])
        self.picture_time_s: Array | None = file["pictures/time_s"][:] if "pictures" in file else None  # of a drive
        self._jpegs = JpegIndex(self._store, self._name, file)

    def __len__(self) -> int:
        return len(self.frame_index)

    @cached_property
    def scenarios(self) -> dict[str, Scenario]:
        """The arenas in the shard, by name; read when first asked for.

        Raises:
            InputError: as `open_shard`.
        """
        with open_shard(self._store, self._name) as file:
            decoded = [msgspec.json.decode(blob, type=Scenario) for blob in take_blobs(file, "scenario")]
        return {scenario.name: scenario for scenario in decoded}

    @cached_property
    def lane_line_columns(self) -> Columns:
        """The lane lines' columns, more than all the others hold; read when first asked for.

        Raises:
            InputError: as `open_shard`.
        """
        with open_shard(self._store, self._name) as file:
            return take_lane_lines(file["lane_lines"])

    def labels(self, row: int) -> tuple[Label, ...]:
        """Return a frame's labels."""
        return labels_at(self.label_columns, row)

    def lane_lines(self, row: int) -> tuple[LaneLine, ...]:
        """Return a frame's lane lines."""
        return lane_lines_at(self.lane_line_columns, row)

    def conditions(self, row: int) -> Conditions:
        """Return a frame's conditions."""
        return conditions_at(self.condition_columns, row)

    def jpeg(self, row: int) -> bytes:
        """Return the picture's bytes as delivered."""
        return self._jpegs.read(row)

    def truth(self) -> tuple[Array, Array]:
        """Return a drive's time stamps in seconds (n,) and the robot's poses in the world (n, 7), see `Pose3.figures`.

        Raises:
            InputError: the shard is damaged, or is not one of a drive.
        """
        with open_shard(self._store, self._name) as file:
            return file["truth/time_s"][:], file["truth/pose_world_robot"][:]

    def picture_row(self, name: str, row: int) -> NDArray[np.unsignedinteger] | None:
        """Return a frame's `depth_mm` or `semantic` (h, w), None where the dataset has none.

        Raises:
            InputError: the shard is damaged.
        """
        with open_shard(self._store, self._name) as file:
            return np.asarray(file[name][row]) if name in file else None


def _check_count(path: str, found: int, wanted: int) -> None:
    if found != wanted:
        raise damaged(path, f"{found} frames", f"{wanted} frames")


def damaged(path: str, found: str, wanted: str = "the file as it was written") -> InputError:
    """Return the error for a dataset's file that cannot be used."""
    return InputError(
        where=path, found=found, wanted=wanted, todo="copy the dataset again, or delete the file and render again"
    )
