"""A drive's rows as the columns of its log."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.drive_log import Columns, DriveLog, texts
from adc_bench.dataset.drive_script import DriveScript
from adc_bench.geometry import Pose3
from adc_bench.sim import Contact, Readings
from adc_bench.world.categories import PanelSign
from adc_bench.world.frame import Frame
from adc_bench.world.robot import Motion
from adc_bench.world.sensors import SensorRig

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Row:
    """A control step: the truth at its beginning, what had arrived and been hit by then, and the command for it."""

    step: int
    time_s: float
    pose_world_robot: Pose3
    motion: Motion
    sign: PanelSign
    bodies: Mapping[str, Pose3]
    torn: frozenset[str]
    readings: Readings
    contacts: Sequence[Contact]
    command: Motion


@dataclass(frozen=True, kw_only=True, eq=False)
class Delivered:
    """A picture, when it was taken, and when the camera's latency had passed."""

    time_s: float
    arrival_time_s: float
    frame: Frame


def log_of(script: DriveScript, rig: SensorRig, rows: Sequence[Row], shots: Sequence[Delivered]) -> DriveLog:
    """Return the log of a drive that is over."""
    hits = [hit for row in rows for hit in row.contacts]
    return DriveLog(
        script=script,
        truth={
            "time_s": _floats([row.time_s for row in rows]),
            "pose_world_robot": _floats([row.pose_world_robot.figures() for row in rows], 7),
            "v_mps": _floats([row.motion.v_mps for row in rows]),
            "omega_radps": _floats([row.motion.omega_radps for row in rows]),
        },
        command={
            "v_mps": _floats([row.command.v_mps for row in rows]),
            "omega_radps": _floats([row.command.omega_radps for row in rows]),
        },
        panel={"sign": texts([row.sign for row in rows])},
        **_sensors(rig, [row.readings for row in rows]),
        contacts={
            "time_s": _floats([hit.time_s for hit in hits]),
            "with_name": texts([hit.with_name for hit in hits]),
            "impulse_ns": _floats([hit.impulse_ns for hit in hits]),
        },
        bodies=_moved_bodies(rows),
        tapes=_torn_tapes(rows),
        pictures={
            "time_s": _floats([shot.time_s for shot in shots]),
            "arrival_time_s": _floats([shot.arrival_time_s for shot in shots]),
        },
    )


def _sensors(rig: SensorRig, readings: Sequence[Readings]) -> dict[str, Columns]:
    encoders, imu = [r.encoders for r in readings], [r.imu for r in readings]
    scans = [r.laser for r in readings if r.laser]
    return {
        "encoders": {
            **_times(np.concatenate([part.time_s for part in encoders]), rig.encoders.latency_s),
            "left_ticks": np.concatenate([part.left_ticks for part in encoders]),
            "right_ticks": np.concatenate([part.right_ticks for part in encoders]),
        },
        "imu": {
            **_times(np.concatenate([part.time_s for part in imu]), rig.imu.latency_s),
            "yaw_rate_radps": np.concatenate([part.yaw_rate_radps for part in imu]),
            "acceleration_x_mps2": np.concatenate([part.acceleration_x_mps2 for part in imu]),
        },
        "laser": {
            **_times(_floats([scan.time_s for scan in scans]), rig.laser.latency_s if rig.laser else 0.0),
            "ranges_m": np.array([scan.ranges_m for scan in scans], dtype=np.float32).reshape(
                len(scans), rig.laser.beams if rig.laser else 0
            ),
        },
    }


def _times(time_s: Array, latency_s: float) -> dict[str, Array]:
    return {"time_s": time_s, "arrival_time_s": time_s + latency_s}


def _moved_bodies(rows: Sequence[Row]) -> Columns:
    """Return a row for each body and step at which its pose is another than the step before."""
    moved = [
        (now.time_s, name, pose.figures())
        for before, now in pairwise(rows)
        for name, pose in now.bodies.items()
        if pose is not before.bodies[name]
    ]
    return {
        "time_s": _floats([time_s for time_s, _, _ in moved]),
        "name": texts([name for _, name, _ in moved]),
        "pose_world_body": _floats([figures for _, _, figures in moved], 7),
    }


def _torn_tapes(rows: Sequence[Row]) -> Columns:
    torn = [(now.time_s, name) for before, now in pairwise(rows) for name in sorted(now.torn - before.torn)]
    return {"time_s": _floats([time_s for time_s, _ in torn]), "name": texts([name for _, name in torn])}


def _floats(values: Sequence[object], *shape: int) -> Array:
    return np.array(values, dtype=np.float64).reshape(-1, *shape)
