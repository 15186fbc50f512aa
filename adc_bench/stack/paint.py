"""White paint on the floor, found in the bird's-eye picture whatever the light level."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.stack.birds_eye import BirdsEye, FloorRegion

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class PaintParams:
    """What counts as paint: a mark narrower than `widest_m` and brighter than the floor around it."""

    widest_m: float = 0.15
    smallest_contrast_levels: float = 5.0
    share_of_brightest: float = 0.45
    share_of_room: float = 0.65  # between the floor and white
    brightest_quantile: float = 0.985
    noise_factor: float = 6.0
    border_cells: int = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class Paint:
    """Paint in one floor picture: `mask` (rows, columns) bool, `contrast` (rows, columns) in units of the local
    floor's brightness.
    """

    region: FloorRegion
    mask: NDArray[np.bool_]
    contrast: NDArray[np.float32]

    def near(self, x_m: float, y_m: float, reach_m: float) -> Array:
        """Return the points (n, 2) at most `reach_m` from x and from y, to a cell."""
        r, reach = self.region, reach_m / self.region.cell_m
        row, column = (r.x_far_m - x_m) / r.cell_m - 0.5, (r.half_width_m - y_m) / r.cell_m - 0.5
        top, left = max(math.ceil(row - reach), 0), max(math.ceil(column - reach), 0)
        bottom, right = max(math.floor(row + reach) + 1, 0), max(math.floor(column + reach) + 1, 0)
        rows, columns = np.nonzero(self.mask[top:bottom, left:right])
        return r.points(np.stack([columns + left, rows + top], axis=1))


def find_paint(birds_eye: BirdsEye, rgb: NDArray[np.uint8], params: PaintParams | None = None) -> Paint:
    """Return the paint in a picture (height, width, 3).

    A white top-hat removes everything wider than a mark (light, shadows, carpet tones); dividing by the background
    leaves a ratio of reflectances, so that one threshold serves the bright and the shaded part of a picture.
    """
    p = params or PaintParams()
    grey = birds_eye.grey(rgb)
    size = round(p.widest_m / birds_eye.region.cell_m)
    opened = cv2.morphologyEx(grey, cv2.MORPH_OPEN, np.ones((size, size), dtype=np.uint8))
    # Smoothed against noise, but along a light's edge a smooth floor lies too low.
    floor = cv2.max(cv2.blur(opened, (3, 3)), cv2.blur(opened, (size, size))).astype(np.float32)
    excess = cv2.blur(grey, (3, 3)).astype(np.float32) - floor
    contrast = np.asarray(excess / (floor + p.smallest_contrast_levels), dtype=np.float32)
    mask = excess > _threshold_levels(contrast, floor, birds_eye.seen, p)
    mask &= inner_cells(birds_eye.seen, p.border_cells)
    return Paint(region=birds_eye.region, mask=mask, contrast=contrast)


def inner_cells(seen: NDArray[np.bool_], border_cells: int) -> NDArray[np.bool_]:
    """Return the seen cells that lie at least `border_cells` from an unseen one."""
    kernel = np.ones((2 * border_cells + 1, 2 * border_cells + 1), dtype=np.uint8)
    return cv2.erode(seen.astype(np.uint8), kernel) > 0


def _threshold_levels(
    contrast: NDArray[np.float32], floor: NDArray[np.float32], seen: NDArray[np.bool_], p: PaintParams
) -> NDArray[np.float32]:
    """Return by how much a mark must outshine the floor (rows, columns), in levels.

    A share of what the brightest marks do, less where the floor is over-exposed and leaves a mark little room below
    white (255), but never what noise alone reaches.
    """
    values = contrast[::2, ::2][seen[::2, ::2]]
    median, brightest = (float(value) for value in np.quantile(values, [0.5, p.brightest_quantile]))
    noise = median + p.noise_factor * 1.4826 * float(np.median(np.abs(values - median)))
    scale = floor + p.smallest_contrast_levels
    mark = np.minimum(p.share_of_brightest * brightest * scale, p.share_of_room * (255.0 - floor))
    return np.asarray(np.maximum(np.maximum(mark, noise * scale), p.smallest_contrast_levels), dtype=np.float32)
