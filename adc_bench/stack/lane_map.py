"""The map behind the lane's lines: which straight or curve of a circuit a line's points lie on, and its landmark."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Path
from adc_bench.stack.ekf import Belief, SeenLine
from adc_bench.stack.lane_lines import LaneLines
from adc_bench.world.course import Course

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class MapParams:
    """Which points are believed to be the lane's own lines."""

    line_tolerance_m: float = 0.15  # from where the map has the line, under the present estimate
    line_sds: float = 3.0  # the tolerance grows with the belief's spread ...
    line_tolerance_max_m: float = 0.32  # ... but stays clear of the next line
    knot_margin_m: float = 0.08  # kept clear of where one piece of the lap meets the next
    window_m: float = 3.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch:
    """A stretch of lane with one curvature, and its lines' points in the robot frame by offset (left positive)."""

    s_m: float
    curvature_pm: float
    points_robot: Mapping[float, Array]

    def by_radius(self) -> Mapping[float, Array]:
        """Return the points by their line's radius; only on a curve."""
        radius_m = 1 / self.curvature_pm
        return {abs(radius_m - offset): points for offset, points in self.points_robot.items()}


@dataclass(frozen=True, kw_only=True)
class LaneMap:
    """The landmarks of a closed lane whose middle is `lap`: a centre for every curve, a line for every straight."""

    course: Course
    lap: Path
    params: MapParams = MapParams()

    @cached_property
    def half_lane_m(self) -> float:
        """From the lane's middle to either of its lines."""
        spec = self.course.spec
        return (spec.radius_outer_m - spec.radius_centre_m) / 2

    @cached_property
    def _pieces(self) -> Array:
        """Rows (start, end, curvature) of the lap's pieces."""
        knots = self.lap.knots_m
        return np.column_stack([knots[:-1], knots[1:], [piece.curvature_pm for piece in self.lap.pieces]])

    def centres(self, curvature_pm: float) -> Array:
        """Return the centres (n, 2) of all curves of this curvature."""
        starts = self.lap.poses(self._pieces[np.isclose(self._pieces[:, 2], curvature_pm), 0])
        normals = np.column_stack([-np.sin(starts[:, 2]), np.cos(starts[:, 2])])
        centres: Array = starts[:, :2] + normals / curvature_pm
        return centres

    def straights(self) -> tuple[SeenLine, ...]:
        """Return the lane's middle on every straight: the normal points left of the driving direction."""
        starts = self.lap.poses(self._pieces[self._pieces[:, 2] == 0, 0])
        normals = np.column_stack([-np.sin(starts[:, 2]), np.cos(starts[:, 2])])
        return tuple(
            SeenLine(normal_rad=float(np.arctan2(n[1], n[0])), distance_m=float(n @ start[:2]))
            for n, start in zip(normals, starts, strict=True)
        )

    def stretches(self, lines: LaneLines, belief: Belief, s_m: float) -> tuple[Stretch, ...]:
        """Return the lines' points sorted by the piece of the lap they lie on, near pieces first.

        `belief` and `s_m` are the present estimate. Points that are not where the map has the line are left out: where
        lanes part, a line that was followed leads away from the lap.
        """
        sides = {
            offset: self._own_points(line.points_robot, offset, belief, s_m)
            for offset, line in ((-self.half_lane_m, lines.right), (self.half_lane_m, lines.left))
            if line is not None
        }
        found = []
        # The piece that ends next is the one under the robot.
        order = np.argsort((self._pieces[:, 1] - s_m) % self.lap.length_m)
        for start, end, curvature in self._pieces[order]:
            middle, half = (start + end) / 2, (end - start) / 2 - self.params.knot_margin_m
            here = {}
            for offset, (points, s) in sides.items():
                distance = (s - middle + self.lap.length_m / 2) % self.lap.length_m - self.lap.length_m / 2
                inside = np.abs(distance) < half
                if inside.any():
                    here[offset] = points[inside]
            if here:
                found.append(Stretch(s_m=float(start), curvature_pm=float(curvature), points_robot=here))
        return tuple(found)

    def _own_points(self, points_robot: Array, offset_m: float, belief: Belief, s_m: float) -> tuple[Array, Array]:
        """Return those points (n, 2) that lie by the map's line, and their arc lengths (n,)."""
        p, ahead = self.params, s_m + float(np.mean(points_robot[:, 0]))
        points_world = belief.pose.transform(points_robot)
        s, offset = self.lap.project(points_world, around_s_m=ahead, window_m=p.window_m)
        spread = np.sqrt(np.trace(belief.covariance[:2, :2]) + belief.covariance[2, 2] * points_robot[:, 0] ** 2)
        tolerance = np.clip(p.line_sds * spread, p.line_tolerance_m, p.line_tolerance_max_m)
        own = np.abs(offset - offset_m) < tolerance
        return points_robot[own], s[own]
