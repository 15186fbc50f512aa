"""A sheet of pictures with truth and answers side by side."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.evaluation.drawing import draw_found, draw_truth, whole
from adc_bench.world.frame import Detections


def sheet_png(
    source: LabelledPictures, found: Sequence[Detections], threshold: float, *, rows: int = 6, columns: int = 3
) -> bytes:
    """Return a PNG of pictures with objects, spread over the dataset: in each pair the truth on the left, what was
    found on the right.
    """
    busy = [i for i in range(len(source)) if any(not label.ignore for label in source.annotations(i))]
    count = min(rows * columns, len(busy))
    chosen = [busy[round(k)] for k in np.linspace(0, len(busy) - 1, count)]
    pairs = [_pair(source, i, found[i], threshold) for i in chosen]
    pairs += [np.zeros_like(pairs[0])] * (-len(pairs) % columns)
    sheet = np.vstack([np.hstack(pairs[k : k + columns]) for k in range(0, len(pairs), columns)])
    _, png = cv2.imencode(".png", cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR))
    return png.tobytes()


def _pair(source: LabelledPictures, index: int, found: Detections, threshold: float) -> NDArray[np.uint8]:
    left, right = source.picture(index).copy(), source.picture(index).copy()
    draw_truth(left, whole(left), source.annotations(index))
    draw_found(right, whole(right), found, threshold)
    return np.hstack([left, right])
