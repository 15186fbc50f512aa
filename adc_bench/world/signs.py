"""The twelve vertical signs: where they stand, what they are made of, and which sign stands where.

Positions, sizes and families: adc.md 6 (CONDE's positions, AUTOMEC's post and height).
"""

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.world.categories import SIGNS, SignCategory
from adc_bench.world.course import CourseSpec
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]

BOARD_M = 0.305
BOARD_THICKNESS_M = 0.01
BOARD_CENTRE_Z_M = 0.75
POST_M, POST_TOP_M = 0.0305, 0.82
BASE_SIZE_M = (0.305, 0.20, 0.05)  # the long side along the traffic, so that the foot keeps off the line
WHITE = (0.85, 0.85, 0.85)
TRIANGLES = ("sign_danger", "sign_dip", "sign_cattle", "sign_narrows")
SQUARES = ("sign_parking", "sign_speed60", "sign_hospital", "sign_crosswalk")

# Set A, world: x, y of the foot and the way the board faces. Three per loop for counter-clockwise traffic outside the
# outer line, three per loop for clockwise traffic inside the inner line. From CONDE's (x, y) by the shifts of
# adc.md 0, (+0.403, +0.246) for the +x loop and (+0.403, -0.225) for the -x loop.
EAST, NORTH, WEST, SOUTH = 0.0, math.pi / 2, math.pi, -math.pi / 2
OUTER_PLACES = (
    (5.246, -3.203, WEST),
    (8.546, -0.403, SOUTH),
    (5.246, 3.197, EAST),
    (-5.225, 3.197, EAST),
    (-8.525, -0.403, NORTH),
    (-5.225, -3.203, WEST),
)
INNER_PLACES = (
    (4.246, -0.403, SOUTH),
    (5.246, 1.197, WEST),
    (6.546, -0.403, NORTH),
    (-5.225, -1.003, EAST),
    (-6.425, -0.403, SOUTH),
    (-5.225, 1.197, WEST),
)


class VerticalSign(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A sign on its post: the post's foot, and the way its board faces (yaw 0: seen by who looks along -x)."""

    name: str
    sign: SignCategory
    x_m: float
    y_m: float
    yaw_rad: float


def sign_places(spec: CourseSpec) -> tuple[Pose2, ...]:
    """Return the twelve feet and facings: `OUTER_PLACES`, then `INNER_PLACES`, as far from the lines of this course as
    from those of set A.
    """
    wider_m = (spec.edge_line_width_m - CourseSpec().edge_line_width_m) / 2
    outer_m = spec.radius_outer_m - CourseSpec().radius_outer_m + wider_m
    inner_m = spec.radius_inner_m - CourseSpec().radius_inner_m - wider_m
    placed = [(place, outer_m) for place in OUTER_PLACES] + [(place, inner_m) for place in INNER_PLACES]
    return tuple(_moved(spec, *place, outwards_m) for place, outwards_m in placed)


def _moved(spec: CourseSpec, x_m: float, y_m: float, yaw_rad: float, outwards_m: float) -> Pose2:
    """Return a place of set A moved outwards from the centre of its loop, along with the loop."""
    side = math.copysign(1.0, x_m)
    dx_m = x_m - side * CourseSpec().loop_centre_x_m
    stretch = 1.0 + outwards_m / math.hypot(dx_m, y_m)
    return Pose2(x_m=side * spec.loop_centre_x_m + stretch * dx_m, y_m=stretch * y_m, yaw_rad=yaw_rad)


def draw_signs(spec: CourseSpec, rng: np.random.Generator) -> tuple[VerticalSign, ...]:
    """Return the twelve signs, each once, permuted over the twelve places."""
    order = rng.permutation(len(SIGNS))
    return tuple(
        VerticalSign(name=f"sign_{k}", sign=SIGNS[int(which)], x_m=p.x_m, y_m=p.y_m, yaw_rad=p.yaw_rad)
        for k, (p, which) in enumerate(zip(sign_places(spec), order, strict=True))
    )


def board_outline(sign: VerticalSign) -> Array:
    """Return the board's outline (n, 2) in metres in its plane: x right seen from the front, y up, centred on the
    board's box, counter-clockwise. A triangle, a square or a circle (as a polygon of 48 corners).
    """
    half = BOARD_M / 2
    if sign.sign in TRIANGLES:
        return np.array([(-half, -half), (half, -half), (0.0, half)])
    if sign.sign in SQUARES:
        return np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    angles = 2 * np.pi * np.arange(48) / 48
    return np.stack([half * np.cos(angles), half * np.sin(angles)], axis=1)


def sign_solids(sign: VerticalSign) -> tuple[Solid, ...]:
    """Return the board (as the box around it; its +x side is the front), the post behind it and the base."""
    foot = Pose2(x_m=sign.x_m, y_m=sign.y_m, yaw_rad=sign.yaw_rad)
    board_x_m = (POST_M + BOARD_THICKNESS_M) / 2
    base_top_m = BASE_SIZE_M[2]
    parts = (
        (sign.name, board_x_m, BOARD_CENTRE_Z_M, (BOARD_THICKNESS_M, BOARD_M, BOARD_M)),
        (f"{sign.name}_post", 0.0, (base_top_m + POST_TOP_M) / 2, (POST_M, POST_M, POST_TOP_M - base_top_m)),
        (f"{sign.name}_base", 0.0, base_top_m / 2, BASE_SIZE_M),
    )
    solids = []
    for name, ahead_m, z_m, size_m in parts:
        (x_m, y_m), *_ = foot.transform([(ahead_m, 0.0)])
        solids.append(
            Solid(
                name=name,
                kind="sign",
                centre_m=(float(x_m), float(y_m), z_m),
                size_m=size_m,
                yaw_rad=sign.yaw_rad,
                albedo=WHITE,
            )
        )
    return tuple(solids)
