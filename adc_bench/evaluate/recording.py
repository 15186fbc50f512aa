"""What a run over a recording shows, observation by observation: a shard of a dataset, made for the run or at hand."""

import contextlib
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from adc_bench.api import EncoderSamples, ImuSamples, LaserScan
from adc_bench.dataset.drive_log import Columns, DriveLog, take_log
from adc_bench.dataset.shard import Shard, open_shard
from adc_bench.dataset.store import Store
from adc_bench.evaluate.recorded_log import DetectionRow, Encoders, LocalizationRow
from adc_bench.evaluate.sensed import Sensed
from adc_bench.generate.drives import render_drive
from adc_bench.generate.frames import render_frames
from adc_bench.generate.plan import ShardTask
from adc_bench.geometry import Pose2, Pose3

SAME_S = 1e-9
NO_SAMPLES: NDArray[np.float64] = np.zeros(0)
NO_TICKS: NDArray[np.int64] = np.zeros(0, np.int64)


@dataclass(frozen=True, kw_only=True)
class AtHand:
    """A finished shard: the dataset's folder or address, the file in it, and how many pictures that has."""

    root: str
    file: str
    frames: int


Source = ShardTask | AtHand


@dataclass(frozen=True, kw_only=True)
class Shown:
    """One observation, and its row without the answer."""

    sensed: Sensed
    row: LocalizationRow | DetectionRow


@contextlib.contextmanager
def shard_of(source: Source) -> Iterator[tuple[Store, str, Shard]]:
    """Give the shard: its store, its name there, and what it holds; one that is made is gone afterwards.

    Raises:
        InputError: it is damaged, or cannot be made.
    """
    if isinstance(source, AtHand):
        store = Store(source.root)
        yield store, source.file, Shard(store, source.file, source.frames)
        return
    data, frames = (render_drive if source.plan.kind == "drives" else render_frames)(source)
    with tempfile.TemporaryDirectory(prefix="adc-bench-") as folder:
        Path(folder, "shard.h5").write_bytes(data)
        store = Store(folder)
        yield store, "shard.h5", Shard(store, "shard.h5", frames)


def drive_in(source: Source) -> list[Shown]:
    """Return a recorded drive, an observation a control step: each tells what arrived since the one before."""
    with shard_of(source) as (store, name, shard):
        with open_shard(store, name) as file:
            log = take_log(file)
        jpegs = [shard.jpeg(row) for row in range(len(shard))]
    return list(_steps(log, shard.cameras, jpegs))


def pictures_in(source: Source, period_s: float) -> list[Shown]:
    """Return a set of pictures, an observation each, `period_s` apart."""
    with shard_of(source) as (_, _, shard):
        return [_picture(shard, index, index * period_s) for index in range(len(shard))]


def _picture(shard: Shard, index: int, time_s: float) -> Shown:
    camera, jpeg = shard.cameras[index], shard.jpeg(index)
    matrix = shard.pose_world_camera[index]
    pose = Pose3(rotation=matrix[:3, :3].copy(), translation_m=matrix[:3, 3].copy())
    labels = tuple(msgspec.structs.replace(label, mask_rle=b"") for label in shard.labels(index))
    row = DetectionRow(
        step=index, time_s=time_s, camera=camera, pose_world_camera=pose.figures(), labels=labels, answer=None
    )
    sensed = Sensed(
        step=index,
        time_s=time_s,
        pictures={camera: (time_s, jpeg)},
        encoders=EncoderSamples(time_s=NO_SAMPLES, left_ticks=NO_TICKS, right_ticks=NO_TICKS),
        imu=ImuSamples(time_s=NO_SAMPLES, yaw_rate_radps=NO_SAMPLES, acceleration_x_mps2=NO_SAMPLES),
    )
    return Shown(sensed=sensed, row=row)


def _steps(log: DriveLog, cameras: list[str], jpegs: list[bytes]) -> Iterator[Shown]:
    times_s, truth = log.truth["time_s"], _poses(log.truth["pose_world_robot"])
    shots = {name: np.flatnonzero(np.array(cameras) == name) for name in sorted(set(cameras))}
    arrived = {name: _arrivals(times_s, log.pictures["arrival_time_s"][rows]) for name, rows in shots.items()}
    encoders, imu, laser = (_arrivals(times_s, group["arrival_time_s"]) for group in (log.encoders, log.imu, log.laser))
    for step, time_s in enumerate(times_s.tolist()):
        came = {name: ends[step + 1] for name, ends in arrived.items() if ends[step + 1] > ends[step]}
        newest = {name: shots[name][end - 1] for name, end in came.items()}
        wheels = _encoders(log.encoders, slice(*encoders[step : step + 2]))
        sensed = Sensed(
            step=step,
            time_s=time_s,
            pictures={name: (float(log.pictures["time_s"][row]), jpegs[row]) for name, row in newest.items()},
            encoders=wheels,
            imu=_imu(log.imu, slice(*imu[step : step + 2])),
            laser=_scan(log.laser, laser[step + 1] - 1) if laser[step + 1] > laser[step] else None,
        )
        row = LocalizationRow(step=step, time_s=time_s, truth=truth[step], encoders=_told(wheels), answer=None)
        yield Shown(sensed=sensed, row=row)


def _arrivals(times_s: NDArray[np.float64], arrival_time_s: NDArray[np.float64]) -> list[int]:
    """Return how many samples had arrived before the first step, and by each step: (steps + 1)."""
    return [0, *np.searchsorted(arrival_time_s, times_s + SAME_S, side="right").tolist()]


def _poses(figures: NDArray[np.float64]) -> list[Pose2]:
    """Return poses (n, 7) as seen from above."""
    forward = Rotation.from_quat(figures[:, 3:]).as_matrix()[:, :2, 0]
    yaw_rad = np.arctan2(forward[:, 1], forward[:, 0])
    rows = zip(figures[:, 0].tolist(), figures[:, 1].tolist(), yaw_rad.tolist(), strict=True)
    return [Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw) for x_m, y_m, yaw in rows]


def _encoders(columns: Columns, rows: slice) -> EncoderSamples:
    return EncoderSamples(
        time_s=columns["time_s"][rows],
        left_ticks=columns["left_ticks"][rows].astype(np.int64),
        right_ticks=columns["right_ticks"][rows].astype(np.int64),
    )


def _told(wheels: EncoderSamples) -> Encoders:
    return Encoders(
        time_s=tuple(wheels.time_s.tolist()),
        left_ticks=tuple(wheels.left_ticks.tolist()),
        right_ticks=tuple(wheels.right_ticks.tolist()),
    )


def _imu(columns: Columns, rows: slice) -> ImuSamples:
    return ImuSamples(
        time_s=columns["time_s"][rows],
        yaw_rate_radps=columns["yaw_rate_radps"][rows],
        acceleration_x_mps2=columns["acceleration_x_mps2"][rows],
    )


def _scan(columns: Columns, row: int) -> LaserScan:
    ranges_m = columns["ranges_m"][row].astype(np.float64)
    return LaserScan(time_s=float(columns["time_s"][row]), ranges_m=ranges_m)
