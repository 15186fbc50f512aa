"""Truth and answers drawn on pictures."""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Detections, Label

Rgb = tuple[int, int, int]
Picture = NDArray[np.uint8]
TRUTH_RGB, IGNORED_RGB, FOUND_RGB = (90, 255, 90), (160, 160, 160), (255, 150, 40)


class Window(NamedTuple):
    """A part of a picture, from (x0, y0) px on, that is shown `scale` times as large."""

    x0: int
    y0: int
    width: int
    height: int
    scale: float

    def show(self, rgb: Picture) -> Picture:
        """Return the part."""
        part = rgb[self.y0 : self.y0 + self.height, self.x0 : self.x0 + self.width]
        size = (round(self.width * self.scale), round(self.height * self.scale))
        return cv2.resize(part, size, interpolation=cv2.INTER_CUBIC).astype(np.uint8, copy=False)

    def place(self, points_px: ArrayLike) -> NDArray[np.int64]:
        """Return where points (n, 2) of the picture are in the part."""
        shown = (np.asarray(points_px, np.float64) - (self.x0, self.y0)) * self.scale
        return np.rint(shown).astype(np.int64)


def whole(rgb: Picture) -> Window:
    """Return the window that shows a whole picture (h, w, 3) as it is."""
    return Window(0, 0, rgb.shape[1], rgb.shape[0], 1.0)


def window_around(box_px: Sequence[float], size_px: tuple[int, int], shown_width: int) -> Window:
    """Return a window of a picture of size (width, height) around a box, with the picture's proportions."""
    x0, y0, x1, y1 = (float(value) for value in box_px)
    width, height = size_px
    share = min(1.0, max(2.5 * (x1 - x0) / width, 2.5 * (y1 - y0) / height, 0.25))
    w, h = round(share * width), round(share * height)
    left = min(max(round((x0 + x1 - w) / 2), 0), width - w)
    top = min(max(round((y0 + y1 - h) / 2), 0), height - h)
    return Window(left, top, w, h, shown_width / w)


def draw_truth(canvas: Picture, window: Window, labels: Sequence[Label], *, named: bool = True) -> None:
    """Draw labels, those to ignore in grey."""
    for label in labels:
        name = "ignored" if label.ignore else CATEGORIES[label.category_id - 1]
        _draw_box(canvas, window, label.box_px, name if named else "", IGNORED_RGB if label.ignore else TRUTH_RGB)


def draw_found(canvas: Picture, window: Window, found: Detections, threshold: float) -> None:
    """Draw the detections at a score of the threshold or above."""
    for box, score, category_id in zip(found.boxes_px, found.scores, found.category_ids, strict=True):
        if score >= threshold:
            _draw_box(canvas, window, box.tolist(), f"{CATEGORIES[category_id - 1]} {score:.2f}", FOUND_RGB)


def draw_corners(canvas: Picture, window: Window, true_px: ArrayLike, found_px: ArrayLike) -> None:
    """Draw the way from each true corner (n, 2) to the one found."""
    for true, found in zip(window.place(true_px).tolist(), window.place(found_px).tolist(), strict=True):
        cv2.line(canvas, true, found, FOUND_RGB, 1, cv2.LINE_AA)
        cv2.circle(canvas, found, 3, FOUND_RGB, 1, cv2.LINE_AA)
        cv2.circle(canvas, true, 3, TRUTH_RGB, 1, cv2.LINE_AA)


def _draw_box(canvas: Picture, window: Window, box_px: Sequence[float], text: str, colour: Rgb) -> None:
    (x0, y0), (x1, y1) = window.place(np.reshape(box_px, (2, 2))).tolist()
    cv2.rectangle(canvas, (x0, y0), (x1 - 1, y1 - 1), colour, 1)
    at = (max(min(x0, canvas.shape[1] - 8 * len(text)), 0), y0 - 4 if y0 > 16 else y0 + 14)
    cv2.putText(canvas, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv2.LINE_AA)
