"""Drawing the furniture of a hall: off the road, clear of signs, bays, road-works and of each other."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import shapely

from adc_bench.world.arena import ArenaSpec, gantry_solids
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.drawing import works_floor
from adc_bench.world.furniture import (
    CABINETS,
    CHAIRS,
    PEOPLE,
    POSTERS,
    Furniture,
    FurnitureKind,
)
from adc_bench.world.layout import Layout
from adc_bench.world.parking import bay_paint
from adc_bench.world.signs import VerticalSign

COUNTS: dict[FurnitureKind, tuple[int, int]] = {"cabinet": (4, 8), "poster": (5, 10), "person": (5, 9), "chair": (3, 6)}
VARIANTS: dict[FurnitureKind, int] = {
    "cabinet": len(CABINETS),
    "poster": len(POSTERS),
    "person": len(PEOPLE),
    "chair": len(CHAIRS),
}
STANDING_RADIUS_M = 0.35  # of a circle that holds a person or a chair
ROAD_MARGIN_M = 0.6  # free floor outside the outer line
THING_MARGIN_M = 0.5  # free floor round signs, cones, boxes, gantry posts and bays
POSTER_GAP_M = 0.001  # between wall and poster
CABINET_GAP_M = 0.05  # between wall and cabinet: a poster has room behind it
TRIES = 40

Circle = tuple[float, float, float]  # x, y, radius


def draw_furniture(
    arena: ArenaSpec, course: Course, layout: Layout, signs: Sequence[VerticalSign], rng: np.random.Generator
) -> tuple[Furniture, ...]:
    """Return the hall's furniture. Cabinets and posters line the walls, chairs and people stand about."""
    taken = kept_clear(course, arena, layout, signs)
    shapely.prepare(taken)
    pieces: list[Furniture] = []
    standing: list[Circle] = []
    hung: list[Circle] = []
    for kind, (low, high) in COUNTS.items():
        circles = hung if kind == "poster" else standing
        for index in range(int(rng.integers(low, high + 1))):
            for _ in range(TRIES):
                piece, radius_m = _draw_piece(kind, f"{kind}_{index}", arena, rng)
                if _is_free(piece, radius_m, circles, taken):
                    pieces.append(piece)
                    circles.append((piece.x_m, piece.y_m, radius_m))
                    break
    return tuple(pieces)


def kept_clear(course: Course, arena: ArenaSpec, layout: Layout, signs: Sequence[VerticalSign]) -> shapely.Geometry:
    """Return the floor on which no furniture may stand: the road and all within it, and room round everything else."""
    things = [shapely.Point(sign.x_m, sign.y_m) for sign in signs]
    things += [shapely.Point(box.x_m, box.y_m).buffer(0.43) for box in layout.boxes]
    if layout.works:
        things.append(works_floor(layout.works))
    always = _always_clear(course.spec, arena)
    return shapely.union_all([always, *(thing.buffer(THING_MARGIN_M) for thing in things)])


@lru_cache(maxsize=4)
def _always_clear(spec: CourseSpec, arena: ArenaSpec) -> shapely.Geometry:
    """Return what is kept clear whatever the layout: the road and all within it, room round gantry and bays."""
    course = Course(spec=spec)
    outline = shapely.Polygon(course.outer_edge.sample(0.1)[:, :2])
    things = [shapely.Point(solid.centre_m[:2]) for solid in gantry_solids(arena, course)]
    things += [shapely.box(*shapely.total_bounds(bay_paint(spec.bay, course.kerb_y_m)))]
    return shapely.union_all(
        [
            outline.buffer(ROAD_MARGIN_M),
            shapely.Polygon(course.bulge_corners).buffer(ROAD_MARGIN_M),
            *(thing.buffer(THING_MARGIN_M) for thing in things),
        ]
    )


def _draw_piece(kind: FurnitureKind, name: str, arena: ArenaSpec, rng: np.random.Generator) -> tuple[Furniture, float]:
    """Draw a piece of this kind, and the radius of a circle that holds it."""
    variant = int(rng.integers(VARIANTS[kind]))
    if kind in ("cabinet", "poster"):
        size_m = CABINETS[variant][0] if kind == "cabinet" else POSTERS[variant][0]
        gap_m = CABINET_GAP_M if kind == "cabinet" else POSTER_GAP_M
        x_m, y_m, yaw_rad = _draw_at_wall(arena, gap_m + size_m[0] / 2, size_m[1] / 2, rng)
        radius_m = math.hypot(size_m[0], size_m[1]) / 2
    else:
        reach_x, reach_y = arena.hall_half_length_m - 0.5, arena.hall_half_width_m - 0.5
        x_m, y_m = float(rng.uniform(-reach_x, reach_x)), float(rng.uniform(-reach_y, reach_y))
        yaw_rad = math.atan2(-y_m, -x_m) + float(rng.normal(0.0, 0.8))
        radius_m = STANDING_RADIUS_M
    return Furniture(name=name, kind=kind, x_m=x_m, y_m=y_m, yaw_rad=yaw_rad, variant=variant), radius_m


def _draw_at_wall(
    arena: ArenaSpec, from_wall_m: float, half_width_m: float, rng: np.random.Generator
) -> tuple[float, float, float]:
    """Draw a place along one of the four walls, facing inwards: x, y, yaw."""
    length_m, width_m = arena.hall_half_length_m, arena.hall_half_width_m
    wall = int(rng.choice(4, p=np.array([length_m, length_m, width_m, width_m]) / (2 * (length_m + width_m))))
    reach_m = (length_m if wall < 2 else width_m) - half_width_m - 0.9
    along_m = float(rng.uniform(-reach_m, reach_m))
    if wall == 0:
        return along_m, width_m - from_wall_m, -math.pi / 2
    if wall == 1:
        return along_m, -width_m + from_wall_m, math.pi / 2
    if wall == 2:
        return length_m - from_wall_m, along_m, math.pi
    return -length_m + from_wall_m, along_m, 0.0


def _is_free(piece: Furniture, radius_m: float, circles: Sequence[Circle], taken: shapely.Geometry) -> bool:
    apart = all(math.hypot(piece.x_m - x, piece.y_m - y) > radius_m + r + 0.05 for x, y, r in circles)
    return apart and (piece.kind == "poster" or taken.distance(shapely.Point(piece.x_m, piece.y_m)) > radius_m)
