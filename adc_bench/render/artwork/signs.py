"""The twelve vertical signs' boards, drawn: white triangles edged red, blue squares, blue discs.

Families, meanings and colours as the competition has them; the drawings are our own.
"""

import itertools
from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.render.artwork.canvas import Array, Canvas, Colour, arc, moved
from adc_bench.world.categories import SignCategory
from adc_bench.world.signs import BOARD_M, VerticalSign, board_outline

SIZE_PX = 256  # of the square around the board
BLUE, RED, WHITE, BLACK = (0, 117, 189), (255, 0, 0), (255, 255, 255), (0, 0, 0)
EDGE = 0.80  # the white triangle in the red one
RIM = 0.93  # the blue in the white edge of squares and discs

# A cow walking left, as a hundred wide.
COW = [
    (1, 26), (3, 23), (8, 22), (13, 25), (17, 24), (21, 17), (23, 14), (24, 0), (29, 0), (29.5, 13), (32, 13), (33, 0),
    (38, 0), (38, 14), (43, 16), (60, 15), (64, 11), (70, 12), (72, 15), (73, 0), (78, 0), (79, 13), (81, 17), (83, 12),
    (84, 0), (89, 0), (90, 20), (93, 30), (94.5, 12), (97, 12), (98, 28), (96, 38), (92, 43), (84, 45), (60, 43),
    (34, 45), (26, 44), (20, 46), (17, 46), (15, 53), (12, 54), (13, 49), (12, 46), (8, 42), (4, 34),
]  # fmt: skip


@cache
def sign_picture(sign: SignCategory) -> NDArray[np.uint8]:
    """Return the front (256, 256, 4) uint8 RGBA of a sign's board, transparent outside its outline.

    The picture is the square BOARD_M wide around the board's middle; its edge colour goes on outside the outline.
    """
    outline = board_outline(VerticalSign(name=sign, sign=sign, x_m=0.0, y_m=0.0, yaw_rad=0.0)) * 2 / BOARD_M
    ground, edge, inner, draw = _DRAWN[sign]
    board = Canvas(SIZE_PX, SIZE_PX, edge)
    board.polygon(inner(outline), ground)
    draw(board)
    shape = Canvas(SIZE_PX, SIZE_PX, BLACK)
    shape.polygon(outline, WHITE)
    rgba = np.dstack([board.picture(), cv2.extractChannel(shape.picture(), 0)])
    rgba.setflags(write=False)
    return rgba


def _within_triangle(outline: Array) -> Array:
    """Shrink a triangle towards the centre of the circle in it, so that its edge is equally wide all round."""
    sides = np.linalg.norm(np.roll(outline, -1, axis=0) - np.roll(outline, 1, axis=0), axis=1)
    centre = sides @ outline / sides.sum()
    shrunk: Array = centre + EDGE * (outline - centre)
    return shrunk


def _within(outline: Array) -> Array:
    return outline * RIM


def _danger(board: Canvas) -> None:
    board.polygon([*arc((0, 0.16), 0.115, 0, 180), (-0.065, -0.4), (0.065, -0.4)], BLACK)
    board.disc((0, -0.59), 0.105, BLACK)


def _dip(board: Canvas) -> None:
    x = np.linspace(-0.5, 0.5, 60)
    top = -0.35 - 0.15 * (1 + np.cos(np.clip(x / 0.36, -1, 1) * np.pi))
    board.polygon([*zip(x, top, strict=True), (0.5, -0.76), (-0.5, -0.76)], BLACK)


def _cattle(board: Canvas) -> None:
    board.polygon(moved(COW, 0.0104, (-0.52, -0.79)), BLACK)


def _narrows(board: Canvas) -> None:
    for side in (1, -1):
        line = np.array([[0.40, -0.76], [0.40, -0.58], [0.16, -0.24], [0.16, 0.16]]) * (side, 1)
        _jointed(board, line, 0.13, BLACK)


def _parking(board: Canvas) -> None:
    board.box(-0.42, -0.66, -0.17, 0.66, WHITE)
    bowl = np.concatenate([[(-0.17, 0.535)], arc((0.08, 0.26), 0.275, 90, -90), [(-0.17, -0.015)]])
    board.stroke(bowl, 0.25, WHITE)


def _speed60(board: Canvas) -> None:
    for x in (-0.42, 0.42):
        board.polygon(_stadium(x, -0.62, 0.62, 0.34), WHITE)
        board.polygon(_stadium(x, -0.43, 0.43, 0.15), BLUE)
    board.box(-0.28, 0.06, -0.05, 0.26, BLUE)
    board.polygon(_stadium(-0.42, -0.62, 0.14, 0.34), WHITE)
    board.polygon(_stadium(-0.42, -0.43, -0.05, 0.15), BLUE)


def _hospital(board: Canvas) -> None:
    for x in (-0.48, 0.22):
        board.box(x, -0.66, x + 0.26, 0.66, WHITE)
    board.box(-0.3, -0.13, 0.3, 0.13, WHITE)


def _crosswalk(board: Canvas) -> None:
    board.polygon([(-0.8, -0.7), (0.8, -0.7), (0, 0.76)], WHITE)
    for x in (-0.5, -0.25, 0.0, 0.25, 0.5):
        board.polygon([(x - 0.07, -0.64), (x + 0.05, -0.64), (x * 0.8 + 0.04, -0.47), (x * 0.8 - 0.06, -0.47)], BLACK)
    board.disc((-0.02, 0.34), 0.085, BLACK)
    for limb, width in (
        ([(0.0, 0.24), (0.02, -0.08)], 0.17),
        ([(0.05, -0.05), (-0.08, -0.24), (-0.17, -0.47)], 0.1),
        ([(0.02, -0.05), (0.14, -0.25), (0.25, -0.42)], 0.1),
        ([(0.0, 0.18), (-0.12, 0.05), (-0.22, 0.0)], 0.07),
        ([(0.02, 0.18), (0.15, 0.04), (0.2, -0.08)], 0.07),
    ):
        _jointed(board, np.array(limb), width, BLACK)


def _turn_left(board: Canvas) -> None:
    bend = arc((0.08, -0.06), 0.24, 0, 90)
    board.arrow(np.concatenate([[(0.32, -0.64)], bend, [(-0.16, 0.18)]]), 0.22, 0.56, WHITE)


def _headlights(board: Canvas) -> None:
    lamp = np.concatenate([arc((0.12, 0.0), (0.5, 0.42), -90, 90), arc((0.12, 0.0), (0.14, 0.42), 90, 270)])
    board.polygon(lamp, WHITE)
    hollow = np.concatenate([arc((0.14, 0.0), (0.38, 0.31), -90, 90), arc((0.14, 0.0), (0.08, 0.31), 90, 270)])
    board.polygon(hollow, BLUE)
    for y in (0.32, 0.11, -0.10, -0.31):
        board.stroke([(-0.14, y), (-0.66, y - 0.16)], 0.09, WHITE)


def _roundabout(board: Canvas) -> None:
    for start in (100, 220, 340):
        board.arrow(arc((0, 0), 0.5, start, start + 66), 0.17, 0.38, WHITE)


def _bus_lane(board: Canvas) -> None:
    board.box(-0.68, -0.3, 0.68, 0.36, WHITE, corner=0.09)
    for x in (-0.56, -0.27, 0.02):
        board.box(x, 0.02, x + 0.24, 0.24, BLUE, corner=0.03)
    board.box(0.32, -0.2, 0.58, 0.24, BLUE, corner=0.03)
    for x in (-0.36, 0.12):
        board.disc((x, -0.31), 0.155, BLUE)
        board.disc((x, -0.31), 0.115, WHITE)


def _stadium(x: float, y0: float, y1: float, radius: float) -> Array:
    """Return the outline of an upright stroke with round ends, between the heights y0 and y1."""
    return np.concatenate([arc((x, y1 - radius), radius, 0, 180), arc((x, y0 + radius), radius, 180, 360)])


def _jointed(board: Canvas, line: Array, width: float, colour: Colour) -> None:
    """Draw a bent line with round joints and square ends."""
    for a, b in itertools.pairwise(line):
        board.stroke([a, b], width, colour)
    for x, y in line[1:-1]:
        board.disc((float(x), float(y)), width / 2, colour)


_Drawn = tuple[Colour, Colour, Callable[[Array], Array], Callable[[Canvas], None]]
_DRAWN: dict[SignCategory, _Drawn] = {
    "sign_danger": (WHITE, RED, _within_triangle, _danger),
    "sign_dip": (WHITE, RED, _within_triangle, _dip),
    "sign_cattle": (WHITE, RED, _within_triangle, _cattle),
    "sign_narrows": (WHITE, RED, _within_triangle, _narrows),
    "sign_parking": (BLUE, WHITE, _within, _parking),
    "sign_speed60": (BLUE, WHITE, _within, _speed60),
    "sign_hospital": (BLUE, WHITE, _within, _hospital),
    "sign_crosswalk": (BLUE, WHITE, _within, _crosswalk),
    "sign_turn_left": (BLUE, WHITE, _within, _turn_left),
    "sign_headlights": (BLUE, WHITE, _within, _headlights),
    "sign_roundabout": (BLUE, WHITE, _within, _roundabout),
    "sign_bus_lane": (BLUE, WHITE, _within, _bus_lane),
}
