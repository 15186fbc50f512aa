"""What a laser scan has met: its points in the robot frame, and the clusters of neighbours that lie close together."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import LaserScan
from adc_bench.world.sensors import LaserSpec

Array = NDArray[np.float64]

RANGE_SHARE = 0.95  # noise of 1 % pulls no beam that met nothing farther under the range's end
GAP_M, GAP_SHARE = 0.12, 0.05  # between neighbours of one thing, and what the distance adds


@dataclass(frozen=True, kw_only=True, eq=False)
class Cluster:
    """Neighbouring returns of one thing: points (n, 2) in the robot frame, from right to left."""

    points_robot: Array

    @cached_property
    def width_m(self) -> float:
        """The distance from the first return to the last."""
        return float(np.hypot(*(self.points_robot[-1] - self.points_robot[0])))

    @cached_property
    def bearings_rad(self) -> Array:
        """The directions (n,) of the returns, seen from the robot."""
        bearings: Array = np.arctan2(self.points_robot[:, 1], self.points_robot[:, 0])
        return bearings


def scan_points(scan: LaserScan, spec: LaserSpec) -> Array:
    """Return the returns (n, 2) in the robot frame, from right to left; beams that met nothing are left out."""
    ranges = np.asarray(scan.ranges_m, dtype=np.float64)
    angles = np.arange(len(ranges)) * spec.step_rad - spec.field_rad / 2
    met = (ranges > spec.range_min_m) & (ranges < RANGE_SHARE * spec.range_max_m)
    return np.column_stack([spec.x_m + ranges[met] * np.cos(angles[met]), ranges[met] * np.sin(angles[met])])


def clusters(scan: LaserScan, spec: LaserSpec) -> tuple[Cluster, ...]:
    """Return the scan's clusters from right to left."""
    return clustered(scan_points(scan, spec), spec)


def clustered(points: Array, spec: LaserSpec) -> tuple[Cluster, ...]:
    """Return the clusters of a scan's points (n, 2), both from right to left: points go together whose neighbours are
    nearer than a gap that grows with the distance.
    """
    if not len(points):
        return ()
    gaps = np.hypot(*np.diff(points, axis=0).T)
    allowed = GAP_M + GAP_SHARE * np.hypot(points[1:, 0] - spec.x_m, points[1:, 1])
    parts = np.split(points, np.flatnonzero(gaps > allowed) + 1)
    return tuple(Cluster(points_robot=part) for part in parts)
