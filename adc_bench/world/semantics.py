"""The classes of a semantic mask: what each pixel shows. Their numbers are fixed for good.

The floor is told apart by the course's description, whatever is left of the paint; of a thing that is labelled, the
class is its category's.
"""

from collections.abc import Mapping
from enum import IntEnum

import shapely

from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.course import Course


class SemanticClass(IntEnum):
    """What a pixel shows that no label is about."""

    FLOOR = 0  # of the hall, off the road
    ROAD = 1  # between the middles of the edge lines, islands left out
    LANE_LINE = 2  # paint: edge lines, the parallel place's line, dashes
    PARALLEL_PLACE = 3  # the bulge beside the road, between its lines
    BAY_PLACE = 4  # within the lines of the two-place bay
    BAY_LINE = 5  # paint: the two-place bay's lines, dashes and letters
    TUNNEL = 6
    WALL = 7  # the hall's walls, ceiling and lamps
    GANTRY = 8  # posts, beam, hangers, the panels' housings
    SIGN_POST = 9  # the vertical signs' posts, feet and the backs of their boards
    FURNITURE = 10  # cabinets, chairs, people-like figures, posters
    TAPE = 11
    ROBOT = 12


CATEGORY_CLASS_0 = 20  # a category's class is this and its id: crosswalk 21 .. cone 41
CLASS_NAMES: Mapping[int, str] = {
    **{int(known): known.name.lower() for known in SemanticClass},
    **{CATEGORY_CLASS_0 + category_id: name for name, category_id in CATEGORY_ID.items()},
}


def category_class(category_id: int) -> int:
    """Return the class of what is labelled with this category."""
    return CATEGORY_CLASS_0 + category_id


def floor_regions(course: Course) -> tuple[tuple[SemanticClass, tuple[shapely.Polygon, ...]], ...]:
    """Return where the classes of the floor lie, each class over those before it; elsewhere it is FLOOR.

    The crosswalk, which is labelled, is none of them.
    """
    bay_lines = course.bay_paint
    return (
        (SemanticClass.ROAD, (course.road,)),
        (SemanticClass.PARALLEL_PLACE, (shapely.Polygon(course.bulge_corners),)),
        (SemanticClass.BAY_PLACE, (shapely.Polygon(bay_lines[0].exterior),)),
        (SemanticClass.BAY_LINE, bay_lines),
        (SemanticClass.LANE_LINE, course.line_paint),
    )
