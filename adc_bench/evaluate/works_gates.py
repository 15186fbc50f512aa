"""Whether a robot drove through the road-works: across the line between the first cones, and that between the last."""

from functools import lru_cache

import shapely

from adc_bench.evaluate.course_progress import Moment
from adc_bench.world.drawing import works_loop
from adc_bench.world.layout import Works
from adc_bench.world.route import Loop

MOUTHS = 2


def is_missed(works: Works, loop: Loop, crossed: frozenset[int]) -> bool:
    """Return whether a half lap round this loop should have led through the road-works and did not."""
    return loop == works_loop(works) and len(crossed) < MOUTHS


def mouths_crossed(works: Works, before: Moment, now: Moment) -> frozenset[int]:
    """Return which mouths the robot's origin crossed, either way: 0 the first in the lap's direction, 1 the last."""
    way = shapely.LineString([(moment.pose.x_m, moment.pose.y_m) for moment in (before, now)])
    return frozenset(index for index, mouth in enumerate(_mouths(works)) if shapely.intersects(mouth, way))


@lru_cache(maxsize=8)
def _mouths(works: Works) -> tuple[shapely.LineString, ...]:
    mouths = tuple(shapely.LineString([works.left[end], works.right[end]]) for end in (0, -1))
    for mouth in mouths:
        shapely.prepare(mouth)
    return mouths
