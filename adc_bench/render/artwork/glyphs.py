"""What stands within the borders of the twelve vertical signs, in a style's hand; the drawings are our own."""

import itertools
from collections.abc import Callable, Mapping

import numpy as np

from adc_bench.render.artwork.canvas import Array, Canvas, Colour, Point, arc, moved
from adc_bench.render.artwork.styles import Style
from adc_bench.world.categories import SignCategory

# A cow walking left, as a hundred wide.
COW = [
    (1, 26), (3, 23), (8, 22), (13, 25), (17, 24), (21, 17), (23, 14), (24, 0), (29, 0), (29.5, 13), (32, 13), (33, 0),
    (38, 0), (38, 14), (43, 16), (60, 15), (64, 11), (70, 12), (72, 15), (73, 0), (78, 0), (79, 13), (81, 17), (83, 12),
    (84, 0), (89, 0), (90, 20), (93, 30), (94.5, 12), (97, 12), (98, 28), (96, 38), (92, 43), (84, 45), (60, 43),
    (34, 45), (26, 44), (20, 46), (17, 46), (15, 53), (12, 54), (13, 49), (12, 46), (8, 42), (4, 34),
]  # fmt: skip


def _danger(board: Canvas, style: Style) -> None:
    top, foot, dot = (size * style.weight for size in (0.115, 0.065, 0.105))
    board.polygon([*arc((0, 0.275 - top), top, 0, 180), (-foot, -0.4), (foot, -0.4)], style.black)
    board.disc((0, -0.59), dot, style.black)


def _dip(board: Canvas, style: Style) -> None:
    x = np.linspace(-0.5, 0.5, 60)
    top = -0.35 - 0.15 * (1 + np.cos(np.clip(x / 0.36, -1, 1) * np.pi))
    board.polygon([*zip(x, top, strict=True), (0.5, -0.76), (-0.5, -0.76)], style.black)


def _cattle(board: Canvas, style: Style) -> None:
    board.polygon(moved(COW, 0.0104, (-0.52, -0.79)), style.black)


def _narrows(board: Canvas, style: Style) -> None:
    for side in (1, -1):
        line = np.array([[0.40, -0.76], [0.40, -0.58], [0.16, -0.24], [0.16, 0.16]]) * (side, 1)
        _jointed(board, line, 0.13 * style.weight, style.black)


def _parking(board: Canvas, style: Style) -> None:
    stem, reach, middle = 0.25 * style.weight, 0.40, 0.26
    board.box(-0.42, -0.66, stem - 0.42, 0.66, style.white)
    turn = reach - stem / 2
    bowl = np.concatenate(
        [[(stem - 0.42, middle + turn)], arc((0.08, middle), turn, 90, -90), [(stem - 0.42, middle - turn)]]
    )
    board.stroke(bowl, stem, style.white)


def _speed60(board: Canvas, style: Style) -> None:
    line = 0.19 * style.weight
    for x in (-0.42, 0.42):
        board.polygon(_stadium(x, -0.62, 0.62, 0.34), style.white)
        board.polygon(_stadium(x, line - 0.62, 0.62 - line, 0.34 - line), style.blue)
    board.box(-0.28, 0.06, -0.05, 0.26, style.blue)
    board.polygon(_stadium(-0.42, -0.62, 0.14, 0.34), style.white)
    board.polygon(_stadium(-0.42, line - 0.62, 0.14 - line, 0.34 - line), style.blue)


def _hospital(board: Canvas, style: Style) -> None:
    bar = 0.26 * style.weight
    for x in (-0.48, 0.48 - bar):
        board.box(x, -0.66, x + bar, 0.66, style.white)
    board.box(-0.3, -bar / 2, 0.3, bar / 2, style.white)


def _crosswalk(board: Canvas, style: Style) -> None:
    board.polygon([(-0.8, -0.7), (0.8, -0.7), (0, 0.76)], style.white)
    for x in (-0.5, -0.25, 0.0, 0.25, 0.5):
        stripe = [(x - 0.07, -0.64), (x + 0.05, -0.64), (x * 0.8 + 0.04, -0.47), (x * 0.8 - 0.06, -0.47)]
        board.polygon(stripe, style.black)
    board.disc((-0.02, 0.34), 0.085, style.black)
    for limb, width in (
        ([(0.0, 0.24), (0.02, -0.08)], 0.17),
        ([(0.05, -0.05), (-0.08, -0.24), (-0.17, -0.47)], 0.1),
        ([(0.02, -0.05), (0.14, -0.25), (0.25, -0.42)], 0.1),
        ([(0.0, 0.18), (-0.12, 0.05), (-0.22, 0.0)], 0.07),
        ([(0.02, 0.18), (0.15, 0.04), (0.2, -0.08)], 0.07),
    ):
        _jointed(board, np.array(limb), width * style.weight, style.black)


def _turn_left(board: Canvas, style: Style) -> None:
    bend = arc((0.08, -0.06), 0.24, 0, 90)
    line = np.concatenate([[(0.32, -0.64)], bend, [(-0.16, 0.18)]])
    board.arrow(line, 0.22 * style.weight, _head(style, 0.56), style.white, swept=style.swept)


def _headlights(board: Canvas, style: Style) -> None:
    line = 0.12 * style.weight
    board.polygon(_lamp(0.12, 0.50, 0.14, 0.42), style.white)
    board.polygon(_lamp(0.14, 0.50 - line, 0.20 - line, 0.43 - line), style.blue)
    for y in (0.32, 0.11, -0.10, -0.31):
        board.stroke([(-0.14, y), (-0.66, y - 0.16)], 0.09 * style.weight, style.white)


def _lamp(x: float, ahead: float, behind: float, high: float) -> Array:
    """Return a lamp's outline about (x, 0): how far it reaches to the right, to the left, up and down."""
    return np.concatenate([arc((x, 0.0), (ahead, high), -90, 90), arc((x, 0.0), (behind, high), 90, 270)])


def _roundabout(board: Canvas, style: Style) -> None:
    for start in (100, 220, 340):
        line = arc((0, 0), 0.5, start, start + 66)
        board.arrow(line, 0.17 * style.weight, _head(style, 0.38), style.white, swept=style.swept)


def _bus_lane(board: Canvas, style: Style) -> None:
    board.box(-0.68, -0.3, 0.68, 0.36, style.white, corner=0.09)
    for x in (-0.56, -0.27, 0.02):
        board.box(x, 0.02, x + 0.24, 0.24, style.blue, corner=0.03)
    board.box(0.32, -0.2, 0.58, 0.24, style.blue, corner=0.03)
    for x in (-0.36, 0.12):
        board.disc((x, -0.31), 0.155, style.blue)
        board.disc((x, -0.31), 0.115, style.white)


def _head(style: Style, size: float) -> Point:
    return size * style.head[0], size * style.head[1]


def _stadium(x: float, y0: float, y1: float, radius: float) -> Array:
    """Return the outline of an upright stroke with round ends, between the heights y0 and y1."""
    return np.concatenate([arc((x, y1 - radius), radius, 0, 180), arc((x, y0 + radius), radius, 180, 360)])


def _jointed(board: Canvas, line: Array, width: float, colour: Colour) -> None:
    """Draw a bent line with round joints and square ends."""
    for a, b in itertools.pairwise(line):
        board.stroke([a, b], width, colour)
    for x, y in line[1:-1]:
        board.disc((float(x), float(y)), width / 2, colour)


GLYPHS: Mapping[SignCategory, Callable[[Canvas, Style], None]] = {
    "sign_danger": _danger,
    "sign_dip": _dip,
    "sign_cattle": _cattle,
    "sign_narrows": _narrows,
    "sign_parking": _parking,
    "sign_speed60": _speed60,
    "sign_hospital": _hospital,
    "sign_crosswalk": _crosswalk,
    "sign_turn_left": _turn_left,
    "sign_headlights": _headlights,
    "sign_roundabout": _roundabout,
    "sign_bus_lane": _bus_lane,
}
