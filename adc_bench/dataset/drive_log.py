"""A drive's log: what was true, commanded and sensed, as groups of columns in the drive's shard.

| group | columns (rows) |
|---|---|
| `truth` | `time_s`, `pose_world_robot` (7), `v_mps`, `omega_radps`: a row each control step |
| `command` | `v_mps`, `omega_radps`: what the robot was told at that step, until the next |
| `panel` | `sign`: what the panels showed |
| `encoders` | `time_s`, `arrival_time_s`, `left_ticks`, `right_ticks` |
| `imu` | `time_s`, `arrival_time_s`, `yaw_rate_radps`, `acceleration_x_mps2` |
| `laser` | `time_s`, `arrival_time_s`, `ranges_m` (beams) |
| `contacts` | `time_s`, `with_name`, `impulse_ns` |
| `bodies` | `time_s`, `name`, `pose_world_body` (7): a row whenever a body has moved since the step before |
| `tapes` | `time_s`, `name`: when a tape tore |
| `pictures` | `time_s`, `arrival_time_s`: a row for each frame of the shard |

Poses are x, y, z in metres and the quaternion x, y, z, w. Times are simulated seconds since the drive's start;
`time_s` is when a sample was taken, `arrival_time_s` when its sensor delivered it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import h5py
import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.columns import put_array, put_blobs, take_blobs
from adc_bench.dataset.drive_script import DriveScript

Columns = Mapping[str, NDArray[Any]]
GROUPS = ("truth", "command", "panel", "encoders", "imu", "laser", "contacts", "bodies", "tapes", "pictures")


@dataclass(frozen=True, kw_only=True, eq=False)
class DriveLog:
    """One drive without its pictures: each group's columns by name, as the table above says."""

    script: DriveScript
    truth: Columns
    command: Columns
    panel: Columns
    encoders: Columns
    imu: Columns
    laser: Columns
    contacts: Columns
    bodies: Columns
    tapes: Columns
    pictures: Columns


def put_log(file: h5py.File, log: DriveLog) -> None:
    """Write a drive's log into its open shard."""
    put_blobs(file, "script", [msgspec.json.encode(log.script)])
    for name in GROUPS:
        group = file.create_group(name)
        for column, values in getattr(log, name).items():
            put_array(group, column, values)


def take_log(file: h5py.File) -> DriveLog:
    """Return the log of an open shard; raises KeyError or a msgspec error if it is none."""
    script = msgspec.json.decode(take_blobs(file, "script")[0], type=DriveScript)
    groups = {name: {column: file[name][column][:] for column in file[name]} for name in GROUPS}
    return DriveLog(script=script, **groups)


def texts(values: list[str]) -> NDArray[np.bytes_]:
    """Return texts (n,) as fixed bytes."""
    return np.array([value.encode() for value in values], dtype=f"S{max(map(len, values), default=1)}")
