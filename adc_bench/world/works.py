"""What may be hit in a layout: green boxes, and the cones of the road-works with the tape between them."""

from itertools import pairwise

import msgspec

from adc_bench.geometry import Pose2
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
