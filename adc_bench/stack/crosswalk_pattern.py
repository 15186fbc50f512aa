"""The crosswalk's painted pattern: origin in its middle, x along the road away from the robot, y left."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from adc_bench.world.course import CourseSpec

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class CrosswalkPattern:
    """Two stop lines and the stripes between them, as the course has them; the same from either side."""

    spec: CourseSpec

    @property
    def half_size_m(self) -> tuple[float, float]:
        """Half the depth along the road, half the width across."""
        return self.spec.crosswalk_depth_m / 2, self.spec.stop_line_length_m / 2

    @property
    def corners(self) -> Array:
        """The four corners (4, 2): near right, near left, far right, far left."""
        half_x, half_y = self.half_size_m
        return np.array([(sx * half_x, sy * half_y) for sx in (-1, 1) for sy in (-1, 1)])

    def outline(self, step_m: float) -> Array:
        """Return points (n, 2) round the pattern, every corner among them, at most `step_m` apart."""
        near_right, near_left, far_right, far_left = self.corners
        ring = (near_right, far_right, far_left, near_left, near_right)
        return np.concatenate([_along(*edge, step_m) for edge in pairwise(ring)])

    @property
    def marks(self) -> Array:
        """The painted rectangles (n, 4) as x0, y0, x1, y1; none overlaps another."""
        c = self.spec
        half_x, half_y = self.half_size_m
        length, width = c.stripe_length_m / 2, c.stripe_width_m / 2
        middles = (np.arange(c.stripe_count) - (c.stripe_count - 1) / 2) * c.stripe_pitch_m
        return np.array(
            [
                (-half_x, -half_y, -half_x + c.stop_line_width_m, half_y),
                (half_x - c.stop_line_width_m, -half_y, half_x, half_y),
                *((-length, y - width, length, y + width) for y in middles),
            ]
        )

    def grid(self, step_m: float, margin_m: float) -> Array:
        """Return points (n, 2) over the pattern and `margin_m` round it."""
        half_x, half_y = (half + margin_m for half in self.half_size_m)
        x, y = np.meshgrid(
            np.arange(-half_x, half_x + 1e-9, step_m), np.arange(-half_y, half_y + 1e-9, step_m), indexing="ij"
        )
        return np.stack([x.ravel(), y.ravel()], axis=1)

    def blurred(self, points: Array, blur_m: float) -> Array:
        """Return the share of paint (n,) in the squares of side `blur_m` about points (n, 2)."""
        low, high = points[:, None, :] - blur_m / 2, points[:, None, :] + blur_m / 2
        overlap = np.minimum(high, self.marks[None, :, 2:]) - np.maximum(low, self.marks[None, :, :2])
        share: Array = np.clip(overlap, 0.0, None).prod(axis=2).sum(axis=1) / blur_m**2
        return share


def _along(start: Array, end: Array, step_m: float) -> Array:
    """Return points (n, 2) from `start` on, `end` left out."""
    count = math.ceil(math.dist(start, end) / step_m)
    points: Array = start + np.arange(count)[:, None] / count * (end - start)
    return points
