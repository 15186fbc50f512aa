"""The TUM trajectory format: a line a pose, `stamp x y z qx qy qz qw`, in metres, quaternions with w >= 0."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from adc_bench.dataset.shard import Shard

Array = NDArray[np.float64]
CAMERA_HEADER = "# frame_index tx_m ty_m tz_m qx qy qz qw  (camera x right, y down, z forward, in the world)\n"
DRIVE_HEADER = "# time_s tx_m ty_m tz_m qx qy qz qw  (robot x forward, y left, z up, in the world)\n"


def camera_rows(shard: Shard, camera: str) -> str:
    """Return the lines of a camera's pictures in a shard; a picture's number stands for its time."""
    rows = [row for row, name in enumerate(shard.cameras) if name == camera]
    return "".join(_lines(shard.frame_index[rows].tolist(), pose_figures(shard.pose_world_camera[rows])))


def drive_text(time_s: Array, pose_world_robot: Array) -> str:
    """Return a drive's whole file; time stamps (n,) in seconds, poses (n, 7)."""
    stamps = [f"{time:.6f}" for time in time_s.tolist()]
    return DRIVE_HEADER + "".join(_lines(stamps, pose_world_robot))


def pose_figures(matrices: Array) -> Array:
    """Return homogeneous matrices (n, 4, 4) as rows of seven figures (n, 7), see `Pose3.figures`."""
    if not len(matrices):
        return np.zeros((0, 7))
    quaternions = Rotation.from_matrix(matrices[:, :3, :3]).as_quat(canonical=True)
    figures: Array = np.hstack([matrices[:, :3, 3], quaternions])
    return figures


def _lines(stamps: Iterable[Any], figures: Array) -> Iterator[str]:
    for stamp, row in zip(stamps, figures.tolist(), strict=True):
        yield f"{stamp} " + " ".join(f"{value:.9f}" for value in row) + "\n"
