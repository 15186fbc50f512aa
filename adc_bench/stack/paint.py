"""White paint on the floor, found in the bird's-eye picture whatever the light level."""

from dataclasses import dataclass
from functools import cached_property

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
    brightest_quantile: float = 0.985
    noise_factor: float = 6.0
    border_cells: int = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class Paint:
    """Paint in one floor picture: `mask` (rows, columns) bool, `contrast` (rows, columns) in units of the local
    floor's brightness, and the marked cells' floor points (n, 2) in the robot frame.
    """

    region: FloorRegion
    mask: NDArray[np.bool_]
    contrast: NDArray[np.float32]
    points_robot: Array

    @cached_property
    def _row_starts(self) -> NDArray[np.intp]:
        return np.concatenate([[0], np.cumsum(np.count_nonzero(self.mask, axis=1))])

    def near(self, x_m: float, reach_m: float) -> Array:
        """Return the points whose x is within `reach_m` of `x_m`, to a cell: points lie in the order of their rows."""
        last = self.region.shape[0]
        top, bottom = ((self.region.x_far_m - x_m + side * reach_m) / self.region.cell_m for side in (-1, 1))
        starts = self._row_starts
        return self.points_robot[starts[min(max(int(top), 0), last)] : starts[min(max(int(bottom) + 1, 0), last)]]


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
    rows, columns = np.nonzero(mask)
    points = birds_eye.region.points(np.stack([columns, rows], axis=1))
    return Paint(region=birds_eye.region, mask=mask, contrast=contrast, points_robot=points)


def inner_cells(seen: NDArray[np.bool_], border_cells: int) -> NDArray[np.bool_]:
    """Return the seen cells that lie at least `border_cells` from an unseen one."""
    kernel = np.ones((2 * border_cells + 1, 2 * border_cells + 1), dtype=np.uint8)
    return cv2.erode(seen.astype(np.uint8), kernel) > 0


def _threshold_levels(
    contrast: NDArray[np.float32], floor: NDArray[np.float32], seen: NDArray[np.bool_], p: PaintParams
) -> NDArray[np.float32]:
    """Return by how much a mark must outshine the floor (rows, columns), in levels.

    A share of what the brightest marks would do on this cell's floor, where white ends at 255: an over-exposed floor
    leaves a mark little room. But never what noise alone reaches.
    """
    values = contrast[::2, ::2][seen[::2, ::2]]
    median, brightest = (float(value) for value in np.quantile(values, [0.5, p.brightest_quantile]))
    noise = median + p.noise_factor * 1.4826 * float(np.median(np.abs(values - median)))
    scale = floor + p.smallest_contrast_levels
    mark = p.share_of_brightest * np.minimum(brightest * scale, 255.0 - floor)
    return np.asarray(np.maximum(np.maximum(mark, noise * scale), p.smallest_contrast_levels), dtype=np.float32)
