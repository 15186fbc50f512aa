"""Flat rectangles: faces of boxes, stretches of floor and wall."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.world.solids import Solid

Array = NDArray[np.float64]
# The six faces of a box in its own frame: (normal axis, sign).
FACES = tuple((axis, sign) for axis in range(3) for sign in (1.0, -1.0))
SCREEN_PROUD_M = 0.0004


@dataclass(frozen=True, kw_only=True, eq=False)
class Rectangle:
    """A flat rectangle: `corner` (3,) is its top left seen from the front; `right` and `down` (3,) span it, metres."""

    corner: Array
    right: Array
    down: Array

    @property
    def normal(self) -> Array:
        """The unit vector (3,) towards the viewer."""
        n = _cross(self.down, self.right)
        return n / math.sqrt(n @ n)

    def at(self, u: Array, v: Array) -> Array:
        """Return points (..., 3) at texture coordinates."""
        points: Array = self.corner + u[..., None] * self.right + v[..., None] * self.down
        return points

    def corners(self) -> Array:
        """Return (4, 3): top left, top right, bottom right, bottom left."""
        return self.at(np.array([0.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0, 1.0]))


def _cross(a: Array, b: Array) -> Array:
    """Return a x b of two vectors (3,); numpy's general one costs twenty times as much."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def floor_rectangle(bounds: tuple[float, float, float, float], z_m: float = 0.0) -> Rectangle:
    """Return the level rectangle x0, y0, x1, y1 seen from above, +y up in its picture."""
    x0, y0, x1, y1 = bounds
    return Rectangle(
        corner=np.array([x0, y1, z_m]), right=np.array([x1 - x0, 0.0, 0.0]), down=np.array([0.0, y0 - y1, 0.0])
    )


def box_faces(solid: Solid) -> Iterator[Rectangle]:
    """Yield the six faces of a solid, seen from outside."""
    pose, size = solid.pose_world_solid(), np.array(solid.size_m)
    for axis, sign in FACES:
        normal = np.zeros(3)
        normal[axis] = sign
        down = np.array([0.0, 0.0, -1.0]) if axis != 2 else np.array([-1.0, 0.0, 0.0])
        right = _cross(normal, down)
        corner = (normal * size - right * size - down * size) / 2
        yield Rectangle(
            corner=pose.transform(corner[None])[0],
            right=pose.rotation @ (right * size),
            down=pose.rotation @ (down * size),
        )


def screen_rectangle(panel: Solid) -> Rectangle:
    """Return a panel's lit screen: its +x face, so little before it that a camera below sees both edges as one."""
    face = next(box_faces(panel))
    return Rectangle(corner=face.corner + SCREEN_PROUD_M * face.normal, right=face.right, down=face.down)


def grid_cells(
    xs: Sequence[float], ys: Sequence[float]
) -> Iterator[tuple[int, int, tuple[float, float, float, float]]]:
    """Yield (column, row, (x0, y0, x1, y1)) of the cells between rising borders."""
    for column, (x0, x1) in enumerate(itertools.pairwise(xs)):
        for row, (y0, y1) in enumerate(itertools.pairwise(ys)):
            yield column, row, (x0, y0, x1, y1)
