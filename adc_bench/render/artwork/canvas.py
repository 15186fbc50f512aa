"""A picture to draw on in units of its half height, x right and y up from its middle, with smooth edges."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Colour = tuple[int, int, int]
Point = tuple[float, float]

FINER = 2  # drawn so many times finer, with smooth edges, then averaged
SHIFT = 4  # binary places of OpenCV's coordinates


class Canvas:
    """Draws shapes in colours (r, g, b) of 0..255, one over the other."""

    def __init__(self, width_px: int, height_px: int, ground: Colour) -> None:
        self.half_width = width_px / height_px
        self._about, self._stretch = np.zeros(2), np.ones(2)
        self._size = (width_px, height_px)
        self._scale = height_px * FINER / 2
        self._middle = np.array([width_px, height_px]) * FINER / 2 - 0.5
        self._rgb = np.full((height_px * FINER, width_px * FINER, 3), ground, np.uint8)

    def picture(self) -> NDArray[np.uint8]:
        """Return what has been drawn, (h, w, 3) uint8."""
        return np.asarray(cv2.resize(self._rgb, self._size, interpolation=cv2.INTER_AREA), np.uint8)

    def stretch(self, by: Point, about: Point) -> None:
        """Stretch all that is drawn from now on, across and up, about a point that stays."""
        self._about, self._stretch = np.array(about), np.array(by)

    def polygon(self, points: ArrayLike, colour: Colour) -> None:
        """Fill a polygon (n, 2)."""
        cv2.fillPoly(self._rgb, [self._fixed(points)], colour, cv2.LINE_AA, shift=SHIFT)

    def disc(self, centre: Point, radius: float, colour: Colour) -> None:
        """Fill a disc."""
        self.polygon(arc(centre, radius, 0, 360), colour)

    def box(self, x0: float, y0: float, x1: float, y1: float, colour: Colour, *, corner: float = 0.0) -> None:
        """Fill an upright rectangle, its corners rounded by a radius."""
        if corner == 0.0:
            self.polygon([(x1, y1), (x0, y1), (x0, y0), (x1, y0)], colour)
            return
        quarters = [(x1, y1, -1, -1, 0), (x0, y1, 1, -1, 90), (x0, y0, 1, 1, 180), (x1, y0, -1, 1, 270)]
        rounded = [arc((x + i * corner, y + j * corner), corner, a, a + 90) for x, y, i, j, a in quarters]
        self.polygon(np.concatenate(rounded), colour)

    def stroke(self, points: ArrayLike, width: float, colour: Colour) -> None:
        """Draw a line (n, 2) of a width, its ends cut square."""
        line = np.asarray(points, np.float64)
        along = np.gradient(line, axis=0)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        side = np.column_stack([-along[:, 1], along[:, 0]]) * width / 2
        self.polygon(np.concatenate([line + side, (line - side)[::-1]]), colour)

    def arrow(self, points: ArrayLike, width: float, head: Point, colour: Colour, *, swept: float = 0.0) -> None:
        """Draw a line (n, 2) that ends in an arrow head beyond its last point; the head's wings may reach back.

        `head` is its length before the last point and its width, `swept` how far the wings reach back of that length.
        """
        line = np.asarray(points, np.float64)
        self.stroke(line, width, colour)
        along = (line[-1] - line[-2]) / np.linalg.norm(line[-1] - line[-2])
        side, tip = np.array([-along[1], along[0]]) * head[1] / 2, line[-1] + along * head[0]
        back = line[-1] - along * swept * head[0]
        self.polygon([back + side, line[-1], back - side, tip], colour)

    def _fixed(self, points: ArrayLike) -> NDArray[np.int32]:
        placed = self._about + (np.asarray(points, np.float64) - self._about) * self._stretch
        pixels = self._middle + placed * (self._scale, -self._scale)
        fixed: NDArray[np.int32] = np.round(pixels * 2**SHIFT).astype(np.int32)
        return fixed


def arc(centre: Point, radius: float | Point, start_deg: float, end_deg: float, count: int = 48) -> Array:
    """Return points (count, 2) of an arc or, with two radii, of an ellipse's; counter-clockwise if end > start."""
    angle = np.radians(np.linspace(start_deg, end_deg, count))
    return np.column_stack([np.cos(angle), np.sin(angle)]) * radius + centre


def moved(points: Sequence[Point], scale: float, to: Point) -> Array:
    """Return the points (n, 2), scaled and then moved."""
    return np.array(points, np.float64) * scale + to
