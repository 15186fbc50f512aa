"""The six panel pictures in a style: green arrows, red X, yellow P and the red-green chequer on black.

Colours and meanings as the competition shows them; the drawings are our own.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from adc_bench.render.artwork.canvas import Array, Canvas, Colour, arc
from adc_bench.render.artwork.styles import STYLES, Style
from adc_bench.world.categories import PanelSign

WIDTH_PX, HEIGHT_PX = 256, 144  # 16:9, the panel's screen
QUARTER_TURNS = {"up": 0, "left": 1, "right": 3}
CELLS = 4
UNLIT = (0, 0, 0)
CHEQUER_BLUE = 42  # in the chequer's green, beyond that of the arrows


@lru_cache(maxsize=64)
def panel_picture(sign: PanelSign, artwork: str) -> NDArray[np.uint8]:
    """Return the picture (144, 256, 4) uint8 RGBA that a panel shows for the sign, in a style of `STYLES`."""
    style = STYLES[artwork]
    screen = Canvas(WIDTH_PX, HEIGHT_PX, UNLIT)
    if sign in QUARTER_TURNS:
        _draw_arrow(screen, style, QUARTER_TURNS[sign])
    elif sign == "stop":
        _draw_cross(screen, style)
    elif sign == "park":
        _draw_p(screen, style)
    else:
        _draw_chequer(screen, style)
    rgb = screen.picture()
    rgba = np.dstack([rgb, np.full(rgb.shape[:2], 255, np.uint8)])
    rgba.setflags(write=False)
    return rgba


def _draw_arrow(screen: Canvas, style: Style, quarter_turns: int) -> None:
    """Draw an arrow pointing up, turned counter-clockwise by quarter turns."""
    tip, size = 0.78 * style.panel, style.panel
    head = 0.72 * style.head[0] * size, 1.33 * style.head[1] * size
    line = np.array([(0.0, -tip), (0.0, tip - head[0])])
    angle = np.pi / 2 * quarter_turns
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    screen.arrow(line @ turn, 0.56 * style.weight * size, head, style.lit_green, swept=style.swept)


def _draw_cross(screen: Canvas, style: Style) -> None:
    reach = 0.67 * style.panel
    for slope in (1, -1):
        _draw_stroke(screen, style, np.array([(-reach, -slope * reach), (reach, slope * reach)]), 0.36, style.lit_red)


def _draw_p(screen: Canvas, style: Style) -> None:
    size = style.panel
    stem, bowl = np.array([(-0.39, -0.64), (-0.39, 0.65)]) * size, arc((-0.19, 0.30), (0.5, 0.35), -90, 90) * size
    _draw_stroke(screen, style, stem, 0.29, style.lit_yellow)
    joined = np.concatenate([[(-0.39 * size, bowl[0, 1])], bowl, [(-0.39 * size, bowl[-1, 1])]])
    screen.stroke(joined, 0.29 * style.weight * size, style.lit_yellow)


def _draw_stroke(screen: Canvas, style: Style, line: Array, width: float, colour: Colour) -> None:
    """Draw a straight stroke whose ends reach half its width beyond those of the line."""
    thick = width * style.weight * style.panel
    along = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0]) * thick / 2
    if style.square_ends:
        screen.stroke(line + np.array([-along, along]), thick, colour)
        return
    screen.stroke(line, thick, colour)
    for x, y in line:
        screen.disc((float(x), float(y)), thick / 2, colour)


def _draw_chequer(screen: Canvas, style: Style) -> None:
    wide, high = (2 * side / CELLS for side in style.chequer)
    red, green, blue = style.lit_green
    colours = style.lit_red, (red, green, min(255, blue + CHEQUER_BLUE))
    for row in range(CELLS):
        for column in range(CELLS):
            x, y = (column - CELLS / 2) * wide, (CELLS / 2 - row) * high
            screen.box(x, y - high, x + wide, y, colours[(row + column) % 2])
