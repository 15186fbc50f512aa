"""What may be hit in a layout: green boxes, and the cones of the road-works with the tape between them.

And whether the road-works leave a way: a robot of the rules' greatest width (adc.md 11) must get from the first cones
to the last.
"""

from itertools import pairwise

import msgspec
import numpy as np
import shapely

from adc_bench.geometry import Pose2
from adc_bench.world.footprints import Extents
from adc_bench.world.layout import BoxPlace, Layout, Place, Works
from adc_bench.world.solids import Body, Solid

BOX_SIZE_M = (0.60, 0.60, 0.30)  # adc.md 8; the height as in the 2017 photo and AUTOMEC
BOX_MASS_KG, BOX_FRICTION = 10.0, 0.5
BOX_ALBEDO = (0.04, 0.55, 0.07)
CONE_SIZE_M = (0.15, 0.15, 0.23)  # adc.md 9
CONE_FOOT_M = 0.02
CONE_MASS_KG, CONE_FRICTION = 4.0, 0.6
CONE_ALBEDO = (0.85, 0.22, 0.02)
TAPE_HEIGHT_M, TAPE_WIDTH_M = 0.18, 0.05
CORRIDOR_WIDTH_M = 0.60
ROBOT_HEIGHT_M = 1.0  # what hangs higher blocks no corridor
TAPE_SLACK = 1.01  # a tape's length over the distance that it spans


class Tape(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A red and white tape between two cones, named; it tears when stretched well beyond its length."""

    name: str
    first: str
    second: str
    rest_length_m: float


def box_body(index: int, place: BoxPlace) -> Body:
    """Return the green box that stands at this place."""
    name = f"box_{index}"
    part = Solid(
        name=f"{name}_body", kind="box", centre_m=(0.0, 0.0, BOX_SIZE_M[2] / 2), size_m=BOX_SIZE_M, albedo=BOX_ALBEDO
    )
    return Body(
        name=name,
        kind="box",
        pose=Pose2(x_m=place.x_m, y_m=place.y_m, yaw_rad=place.yaw_rad),
        mass_kg=BOX_MASS_KG,
        friction=BOX_FRICTION,
        parts=(part,),
        category="box",
    )


def cone_body(name: str, place: Place) -> Body:
    """Return the cone of this name: a square foot and a cone on it."""
    length, width, height = CONE_SIZE_M
    foot = Solid(
        name=f"{name}_foot",
        kind="cone",
        centre_m=(0.0, 0.0, CONE_FOOT_M / 2),
        size_m=(length, width, CONE_FOOT_M),
        albedo=CONE_ALBEDO,
    )
    cone = Solid(
        name=f"{name}_cone",
        kind="cone",
        shape="cone",
        centre_m=(0.0, 0.0, (CONE_FOOT_M + height) / 2),
        size_m=(0.8 * length, 0.8 * width, height - CONE_FOOT_M),
        albedo=CONE_ALBEDO,
    )
    return Body(
        name=name,
        kind="cone",
        pose=Pose2(x_m=place[0], y_m=place[1], yaw_rad=0.0),
        mass_kg=CONE_MASS_KG,
        friction=CONE_FRICTION,
        parts=(foot, cone),
        category="cone",
    )


def layout_bodies(layout: Layout) -> tuple[Body, ...]:
    """Return the layout's boxes and cones, in the order of their names."""
    boxes = [box_body(index, place) for index, place in enumerate(layout.boxes)]
    cones = [cone_body(name, place) for row in _rows(layout.works) for name, place in row]
    return (*boxes, *cones)


def layout_tapes(layout: Layout) -> tuple[Tape, ...]:
    """Return the tapes of the road-works: one between each two neighbours of a row."""
    tapes = []
    for side, row in zip(("left", "right"), _rows(layout.works), strict=False):
        for index, ((first, a), (second, b)) in enumerate(pairwise(row)):
            distance_m = ((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5
            tapes.append(
                Tape(name=f"tape_{side}_{index}", first=first, second=second, rest_length_m=TAPE_SLACK * distance_m)
            )
    return tuple(tapes)


def _rows(works: Works | None) -> tuple[tuple[tuple[str, Place], ...], ...]:
    """Return the left and the right row of named cones, or nothing."""
    if works is None:
        return ()
    rows = (("left", works.left), ("right", works.right))
    return tuple(tuple((f"cone_{side}_{k}", place) for k, place in enumerate(row)) for side, row in rows)


def is_swapped(works: Works) -> bool:
    """Return whether the left row lies to the right of the right one in driving order."""
    return bool(shapely.is_ccw(shapely.LinearRing([*works.left, *reversed(works.right)])))


def blocked_by(works: Works, things: Extents) -> tuple[str, ...]:
    """Return the names of what blocks the corridor; nothing if a disc `CORRIDOR_WIDTH_M` wide gets through.

    The corridor is the floor between the two rows, from the line between the first cones to that between the last.
    `things` holds the cones themselves and whatever else stands; tapes run straight from cone to cone.
    """
    left, right = np.array(works.left), np.array(works.right)
    corridor = shapely.Polygon(np.concatenate([left, right[::-1]]))
    if not corridor.is_valid:  # the rows cross
        return _nearest_cones(works)
    low = (things.low[:, 2] < ROBOT_HEIGHT_M) & (things.low[:, :2] < corridor.bounds[2:]).all(axis=1)
    low &= (things.high[:, :2] > corridor.bounds[:2]).all(axis=1)
    footprints = {int(k): things.footprint(int(k)) for k in np.flatnonzero(low)}
    tapes = [shapely.LineString(row).buffer(TAPE_WIDTH_M / 2, cap_style="flat") for row in (left, right)]
    own = [polygon for k, polygon in footprints.items() if things.owner[k].startswith("cone_")]
    if _has_way(corridor, left, right, [*tapes, *footprints.values()]):
        return ()
    if not _has_way(corridor, left, right, [*tapes, *own]):
        return _nearest_cones(works)
    others = {k: polygon for k, polygon in footprints.items() if not things.owner[k].startswith("cone_")}
    met = [things.owner[k] for k, polygon in others.items() if polygon.distance(corridor) < CORRIDOR_WIDTH_M / 2]
    return tuple(dict.fromkeys(met))


def _has_way(corridor: shapely.Polygon, left: np.ndarray, right: np.ndarray, obstacles: list[shapely.Polygon]) -> bool:
    """Return whether the middle of a disc can move from the line between the first cones to that between the last."""
    free = corridor.difference(shapely.union_all(obstacles).buffer(CORRIDOR_WIDTH_M / 2))
    mouth, end = (shapely.LineString([left[k], right[k]]).buffer(1e-6) for k in (0, -1))
    parts = shapely.get_parts(free)
    return bool(np.any(shapely.intersects(parts, mouth) & shapely.intersects(parts, end)))


def _nearest_cones(works: Works) -> tuple[str, str]:
    """Return the names of the two cones of different rows that stand nearest to each other."""
    left, right = np.array(works.left), np.array(works.right)
    apart_m = np.linalg.norm(left[:, None] - right[None, :], axis=2)
    i, j = np.unravel_index(int(apart_m.argmin()), apart_m.shape)
    return f"cone_left_{i}", f"cone_right_{j}"
