"""The six panel pictures, drawn: green arrows, red X, yellow P and the red-green chequer on black.

Colours and meanings as the competition shows them; the drawings are our own.
"""

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.world.categories import PanelSign

WIDTH_PX, HEIGHT_PX = 256, 144  # 16:9, the panel's screen
GREEN, RED, YELLOW = (0, 255, 0), (255, 0, 0), (255, 255, 0)


@cache
def panel_picture(sign: PanelSign) -> NDArray[np.uint8]:
    """Return the picture (144, 256, 4) uint8 RGBA that a panel shows for the sign."""
    rgb = np.zeros((HEIGHT_PX, WIDTH_PX, 3), np.uint8)
    if sign in ("up", "left", "right"):
        _draw_arrow(rgb, quarter_turns={"up": 0, "left": 1, "right": 3}[sign])
    elif sign == "stop":
        _draw_cross(rgb)
    elif sign == "park":
        _draw_p(rgb)
    else:
        _draw_chequer(rgb)
    rgba = np.dstack([rgb, np.full(rgb.shape[:2], 255, np.uint8)])
    rgba.setflags(write=False)
    return rgba


def _draw_arrow(rgb: NDArray[np.uint8], quarter_turns: int) -> None:
    """Draw an arrow pointing up, turned counter-clockwise by quarter turns."""
    arrow = np.array([[0, -56], [48, -4], [20, -4], [20, 56], [-20, 56], [-20, -4], [-48, -4]], np.float64)
    angle = -np.pi / 2 * quarter_turns
    c, s = np.cos(angle), np.sin(angle)
    points = arrow @ np.array([[c, s], [-s, c]]) + (WIDTH_PX / 2, HEIGHT_PX / 2)
    cv2.fillPoly(rgb, [np.round(points * 16).astype(np.int32)], GREEN, cv2.LINE_AA, shift=4)


def _draw_cross(rgb: NDArray[np.uint8]) -> None:
    cx, cy, reach = WIDTH_PX // 2, HEIGHT_PX // 2, 48
    for slope in (1, -1):
        cv2.line(rgb, (cx - reach, cy - slope * reach), (cx + reach, cy + slope * reach), RED, 26, cv2.LINE_AA)


def _draw_p(rgb: NDArray[np.uint8]) -> None:
    x, top, bottom = WIDTH_PX // 2 - 28, 18, HEIGHT_PX - 18
    cv2.line(rgb, (x, top + 8), (x, bottom - 8), YELLOW, 22, cv2.LINE_AA)
    cv2.ellipse(rgb, (x + 14, top + 32), (36, 25), 0, -90, 90, YELLOW, 20, cv2.LINE_AA)
    for y in (top + 8, top + 57):
        cv2.line(rgb, (x, y), (x + 14, y), YELLOW, 20, cv2.LINE_AA)


def _draw_chequer(rgb: NDArray[np.uint8]) -> None:
    cell = HEIGHT_PX // 4
    left = (WIDTH_PX - 4 * cell) // 2
    for row in range(4):
        for column in range(4):
            colour = RED if (row + column) % 2 == 0 else (0, 255, 42)
            x, y = left + column * cell, row * cell
            cv2.rectangle(rgb, (x, y), (x + cell - 1, y + cell - 1), colour, -1)
