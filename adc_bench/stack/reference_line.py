"""The line to drive: a path of lines and arcs, rounded where its curvature jumps.

A robot cannot change its curvature at once. Of all lines beside the path the rounded one is that with the least
    int (r^3 kappa'(s))^2 + d(s)^2 ds,
d being its offset from the path and kappa'(s) how fast its curvature changes. With kappa = kappa_path + d'' that is a
low pass on the path's curvature, 1 / (1 + (r w)^6): long arcs and straights stay where they are, a jump by J is spread
into a slope of about J / (3 r), and the offset is a few millimetres.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from adc_bench.geometry import Path, Pose2

Array = NDArray[np.float64]

STEP_M = 0.02
ROUNDING_M = 0.20  # at 2.2 m/s the S-roads then ask for two thirds of what the wheels can turn up


@dataclass(frozen=True, kw_only=True, eq=False)
class ReferenceLine:
    """A curve by samples (n,) no farther apart than about `STEP_M`, from its start to its end.

    Attributes:
        s_m: arc length along the line, from 0.
        path_s_m: where on the path the sample was taken, growing beyond a lap on a closed one.
        x_m, y_m, yaw_rad: the pose; yaw is continuous, not wrapped.
        curvature_pm: left positive.
    """

    s_m: Array
    path_s_m: Array
    x_m: Array
    y_m: Array
    yaw_rad: Array
    curvature_pm: Array

    @property
    def length_m(self) -> float:
        """The arc length of the whole line."""
        return float(self.s_m[-1])

    def pose(self, s_m: float) -> Pose2:
        """Return the pose at an arc length, held at the ends."""
        return Pose2(
            x_m=float(np.interp(s_m, self.s_m, self.x_m)),
            y_m=float(np.interp(s_m, self.s_m, self.y_m)),
            yaw_rad=float(np.interp(s_m, self.s_m, self.yaw_rad)),
        )

    def curvature(self, s_m: float) -> float:
        """Return the curvature in 1/m at an arc length."""
        return float(np.interp(s_m, self.s_m, self.curvature_pm))

    def part(self, from_m: float, to_m: float) -> "ReferenceLine":
        """Return the line from about one arc length to another; it begins and ends on samples just outside."""
        low, high = np.searchsorted(self.s_m, from_m, side="right") - 1, np.searchsorted(self.s_m, to_m) + 1
        kept = slice(max(int(low), 0), int(high))
        return ReferenceLine(
            s_m=self.s_m[kept] - self.s_m[kept][0],
            path_s_m=self.path_s_m[kept],
            x_m=self.x_m[kept],
            y_m=self.y_m[kept],
            yaw_rad=self.yaw_rad[kept],
            curvature_pm=self.curvature_pm[kept],
        )

    def project(self, pose: Pose2, around_s_m: float, window_m: float = 0.5) -> float:
        """Return the arc length of the nearest point within a window, so that a line that crosses itself keeps its
        branch.
        """
        low, high = np.searchsorted(self.s_m, (around_s_m - window_m, around_s_m + window_m))
        low, high = max(int(low) - 1, 0), min(int(high) + 1, len(self.s_m))
        dx, dy = pose.x_m - self.x_m[low:high], pose.y_m - self.y_m[low:high]
        nearest = int(np.argmin(dx * dx + dy * dy))
        yaw = self.yaw_rad[low + nearest]
        along = float(np.cos(yaw) * dx[nearest] + np.sin(yaw) * dy[nearest])
        return min(max(float(self.s_m[low + nearest]) + along, 0.0), self.length_m)


def rounded(path: Path, from_m: float, to_m: float, rounding_m: float = ROUNDING_M) -> ReferenceLine:
    """Return the line along a path between two arc lengths, rounded over a length r of `rounding_m` at the jumps.

    On a closed path the arc lengths may pass its end as often as wanted. Its ends lie on the path.
    """
    count = round((to_m - from_m) / STEP_M)
    step_m = (to_m - from_m) / count
    path_s_m = np.linspace(from_m, to_m, count + 1)
    poses = path.poses(path_s_m)
    offset_m = _offsets(line_through(poses[:, :2], path_s_m).curvature_pm, rounding_m / step_m) * step_m**2
    normals = np.column_stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2])])
    return line_through(poses[:, :2] + offset_m[:, None] * normals, path_s_m)


def line_through(points_world: Array, path_s_m: Array) -> ReferenceLine:
    """Return the line through points (n, 2), dense enough to be joined by chords."""
    gaps = np.diff(points_world, axis=0)
    s_m = np.concatenate([[0.0], np.cumsum(np.hypot(gaps[:, 0], gaps[:, 1]))])
    chords_rad = np.unwrap(np.arctan2(gaps[:, 1], gaps[:, 0]))
    middles_m = (s_m[1:] + s_m[:-1]) / 2
    curvature_pm = np.diff(chords_rad) / np.diff(middles_m)
    curvature_pm = np.concatenate([curvature_pm[:1], curvature_pm, curvature_pm[-1:]])
    inside_rad = np.interp(s_m[1:-1], middles_m, chords_rad)
    ends_rad = (
        chords_rad[0] - curvature_pm[0] * middles_m[0],
        chords_rad[-1] + curvature_pm[-1] * (s_m[-1] - middles_m[-1]),
    )
    return ReferenceLine(
        s_m=s_m,
        path_s_m=path_s_m,
        x_m=points_world[:, 0],
        y_m=points_world[:, 1],
        yaw_rad=np.concatenate([ends_rad[:1], inside_rad, ends_rad[1:]]),
        curvature_pm=curvature_pm,
    )


def _offsets(curvature: Array, rounding: float) -> Array:
    """Return the offsets (n,) that solve the page's problem with a step of 1 between samples, 0 beyond the ends.

    Its normal equations are (1 + r^6 D6) d = r^6 D4 kappa with differences D of order 6 (negated) and 4.
    """
    weight = rounding**6
    jumps = np.pad(curvature, 2, mode="edge")
    fourth = np.convolve(jumps, [1.0, -4.0, 6.0, -4.0, 1.0], mode="valid")
    bands = weight * np.array([-1.0, 6.0, -15.0, 20.0])[:, None] * np.ones((1, len(curvature)))
    bands[-1] += 1.0
    offsets: Array = solveh_banded(bands, weight * fourth)
    return offsets
