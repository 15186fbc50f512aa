"""Where a robot may drive in a run, and which lines count: the road, and what the trial opens beside it."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from adc_bench.world.course import Course
from adc_bench.world.drawing import works_floor
from adc_bench.world.layout import Layout
from adc_bench.world.parking import ParkingKind
from adc_bench.world.parking_zones import bay_apron, bay_limits

WORKS_MARGIN_M = 1.0  # round the cones: the way out of the road and back onto it


@dataclass(frozen=True, kw_only=True, eq=False)
class Ground:
    """`drivable` is the floor that counts as the road; a wheel within `touch_m` of the middle of `lines` touches it."""

    drivable: shapely.Geometry
    lines: shapely.Geometry
    touch_m: float

    def is_drivable(self, points_world: ArrayLike) -> NDArray[np.bool_]:
        """Return for each point (n, 2) whether it lies on floor that counts as the road."""
        points = np.asarray(points_world, dtype=np.float64)
        inside: NDArray[np.bool_] = shapely.contains_xy(self.drivable, points[:, 0], points[:, 1])
        return inside

    def distance_to_lines_m(self, points_world: ArrayLike) -> NDArray[np.float64]:
        """Return the distance (n,) from each point (n, 2) to the middle of the nearest line that counts."""
        points = shapely.points(np.asarray(points_world, dtype=np.float64))
        distance: NDArray[np.float64] = shapely.distance(self.lines, points)
        return distance


@lru_cache(maxsize=8)
def ground_of(course: Course, layout: Layout, parking: ParkingKind | None) -> Ground:
    """Return the ground of a run.

    Solid edge lines count. Round road-works, islands apart, and before the two-place bay where that is to be parked in,
    the road's lines do not count and the floor beside the road is part of it; the bay's own far and side lines count.
    """
    opened, limits = [], []
    if layout.works:
        islands = shapely.union_all([shapely.Polygon(drop.sample(0.02)[:, :2]) for drop in course.drops])
        round_works = works_floor(layout.works).buffer(WORKS_MARGIN_M)
        opened.append(shapely.difference(round_works, islands.buffer(course.spec.edge_line_width_m)))
    if parking == "bay":
        opened.append(bay_apron(course))
        limits.append(bay_limits(course))
    edges = shapely.MultiLineString(list(course.edge_lines.values()))
    free = shapely.union_all(opened)
    ground = Ground(
        drivable=shapely.union(course.road, free),
        lines=shapely.union_all([shapely.difference(edges, free), *limits]),
        touch_m=course.spec.edge_line_width_m / 2,
    )
    shapely.prepare(ground.drivable)
    shapely.prepare(ground.lines)
    return ground
