"""The detector as a submission of its own: pictures in, what the contract calls detections out."""

from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import Detection, Mission, Point
from adc_bench.detector.decode import TO_BE_SCORED
from adc_bench.detector.predict import Detector
from adc_bench.world.categories import CATEGORIES, Category
from adc_bench.world.frame import Detections

WITHOUT_CORNERS = ("box", "cone")


class LoneDetector:
    """The network of a weights file, asked about one picture after another.

    Raises:
        InputError: the file cannot be read, or its tensors do not fit its network.
    """

    def __init__(self, weights: Path) -> None:
        self._detector = Detector.load(weights, config=TO_BE_SCORED)

    def start(self, mission: Mission) -> None:
        """Need nothing of the mission."""

    def detect(self, rgb: NDArray[np.uint8]) -> list[Detection]:
        """Return what is on a picture (height, width, 3), best first."""
        found = self._detector(rgb)
        return [_detection(found, k) for k in range(len(found.scores))]


def _detection(found: Detections, k: int) -> Detection:
    left, top, right, bottom = found.boxes_px[k].tolist()
    category = cast(Category, CATEGORIES[int(found.category_ids[k]) - 1])
    corners = cast(tuple[Point, Point, Point, Point], tuple((u, v) for u, v in found.keypoints_px[k].tolist()))
    return Detection(
        category=category,
        score=float(found.scores[k]),
        box_px=(left, top, right, bottom),
        corners_px=None if category in WITHOUT_CORNERS else corners,
    )
