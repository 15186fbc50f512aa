"""Trajectories in the format of KITTI's odometry: `poses/<name>.txt` and `sequences/<name>/times.txt`, a line a pose.

A pose is the first three rows of its 4x4 matrix, twelve figures. Unlike KITTI's own, poses are those in the world, not
relative to the first. `tum.py` says which trajectories there are and what their times mean.
"""

from collections.abc import Iterator

import numpy as np

from adc_bench.dataset.export.format import Format
from adc_bench.dataset.export.tum import trajectories
from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.store import Store
from adc_bench.geometry import Pose3


def write(dataset: FrameDataset, _: str, out: Store) -> Iterator[int]:
    """Write two files for each trajectory."""
    for name, data in trajectories(dataset):
        rows = [line.split() for line in data.decode().splitlines() if not line.startswith("#")]
        poses = [Pose3.from_figures([float(figure) for figure in row[1:]]) for row in rows]
        out.write(f"poses/{name}.txt", "".join(_line(pose) for pose in poses).encode())
        out.write(f"sequences/{name}/times.txt", "".join(f"{row[0]}\n" for row in rows).encode())
    yield len(dataset)


def _line(pose: Pose3) -> str:
    return " ".join(f"{figure:.9f}" for figure in np.ravel(pose.matrix()[:3])) + "\n"


FORMAT = Format(write=write)
