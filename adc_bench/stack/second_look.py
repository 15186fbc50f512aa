"""A second look at a panel that is seen small: the middle of what is round it, enlarged, to the same detector."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.stack.localizer import Detect
from adc_bench.stack.panel import SIGN_OF_CATEGORY
from adc_bench.world.frame import Detections

PANEL_IDS = np.array(sorted(SIGN_OF_CATEGORY))


@dataclass(frozen=True, kw_only=True)
class SecondLook:
    """A detector whose word on the best panel of a picture, where that is small, is from a part of it, enlarged."""

    detect: Detect
    small_px: tuple[float, float] = (14.0, 28.0)  # wide: from 6 m to 3 m off
    enlarged: int = 2

    def __call__(self, rgb: NDArray[np.uint8]) -> Detections:
        """Return what a picture (height, width, 3) shows; boxes and corners are those of the first look."""
        first = self.detect(rgb)
        panels = np.flatnonzero(np.isin(first.category_ids, PANEL_IDS))
        if not len(panels) or not self._is_small(first.boxes_px[panels[0]]):
            return first
        again = self.detect(self._part(rgb, first.boxes_px[panels[0]]))
        better = np.flatnonzero(np.isin(again.category_ids, PANEL_IDS))
        return _renamed(first, int(panels[0]), again, int(better[0])) if len(better) else first

    def _is_small(self, box_px: NDArray[np.float32]) -> bool:
        least_px, most_px = self.small_px
        return least_px <= float(box_px[2] - box_px[0]) < most_px

    def _part(self, rgb: NDArray[np.uint8], box_px: NDArray[np.float32]) -> NDArray[np.uint8]:
        """Return the part about a box, as large as the picture."""
        size = np.array(rgb.shape[:2]) // self.enlarged
        middle = np.array([box_px[1] + box_px[3], box_px[0] + box_px[2]]) / 2
        top, left = np.clip((middle - size / 2).astype(int), 0, np.array(rgb.shape[:2]) - size)
        part = rgb[top : top + size[0], left : left + size[1]]
        larger = cv2.resize(part, (rgb.shape[1], rgb.shape[0]), interpolation=cv2.INTER_CUBIC)
        return np.asarray(larger, dtype=np.uint8)


def _renamed(first: Detections, index: int, again: Detections, other: int) -> Detections:
    """Return the first detections with one named and scored as it is in others."""
    ids, scores = first.category_ids.copy(), first.scores.copy()
    ids[index], scores[index] = again.category_ids[other], again.scores[other]
    return replace(first, category_ids=ids, scores=scores)
