"""The second look: what it shows to the detector, and whose word counts."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from adc_bench.stack.second_look import SecondLook
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.frame import Detections

Seen = tuple[str, float, tuple[float, float, float, float]]
TINY, SMALL, LARGE = (150.0, 150.0, 160.0, 155.0), (150.0, 150.0, 169.0, 160.0), (140.0, 130.0, 180.0, 152.0)
PICTURE = np.arange(240 * 320 * 3).reshape(240, 320, 3).astype(np.uint8)


def picture(*seen: Seen) -> Detections:
    count = len(seen)
    return Detections(
        boxes_px=np.array([box for _, _, box in seen], dtype=np.float32).reshape(-1, 4),
        scores=np.array([score for _, score, _ in seen], dtype=np.float32),
        category_ids=np.array([CATEGORY_ID[name] for name, _, _ in seen], dtype=np.int64),
        keypoints_px=np.zeros((count, 4, 2), dtype=np.float32),
        keypoint_sigma_px=np.ones((count, 4), dtype=np.float32),
        keypoint_scores=np.zeros((count, 4), dtype=np.float32),
    )


@dataclass
class Told:
    """A detector that is told its answers, and keeps what it was shown."""

    answers: list[Detections]
    shown: list[NDArray[np.uint8]] = field(default_factory=list)

    def __call__(self, rgb: NDArray[np.uint8]) -> Detections:
        self.shown.append(rgb)
        return self.answers[len(self.shown) - 1]


def test_a_small_panel_is_named_by_what_is_seen_of_it_enlarged() -> None:
    first = picture(("crosswalk", 0.8, LARGE), ("panel_stop", 0.45, SMALL))
    detect = Told([first, picture(("panel_park", 0.85, LARGE))])
    seen = SecondLook(detect=detect)(PICTURE)
    assert [shown.shape for shown in detect.shown] == [PICTURE.shape] * 2
    np.testing.assert_array_equal(seen.category_ids, [CATEGORY_ID["crosswalk"], CATEGORY_ID["panel_park"]])
    assert seen.scores == pytest.approx([0.8, 0.85])
    np.testing.assert_array_equal(seen.boxes_px, first.boxes_px)
    assert first.category_ids[1] == CATEGORY_ID["panel_stop"]


@pytest.mark.parametrize("box", [SMALL, (0.0, 0.0, 20.0, 10.0), (300.0, 230.0, 320.0, 240.0)])
def test_the_part_lies_in_the_picture_and_holds_the_box(box: tuple[float, float, float, float]) -> None:
    grey = np.zeros((240, 320, 3), dtype=np.uint8)
    x0, y0, x1, y1 = (int(edge) for edge in box)
    grey[y0:y1, x0:x1] = 200
    detect = Told([picture(("panel_stop", 0.5, box)), picture()])
    SecondLook(detect=detect)(grey)
    assert np.count_nonzero(detect.shown[1][..., 0] > 100) == pytest.approx(4 * (x1 - x0) * (y1 - y0), rel=0.15)


@pytest.mark.parametrize(
    "seen",
    [[], [("box", 0.9, SMALL)], [("panel_up", 0.9, LARGE)], [("panel_up", 0.9, TINY)]],
    ids=["none", "no panel", "large", "tiny"],
)
def test_what_is_no_small_panel_is_looked_at_once(seen: list[Seen]) -> None:
    detect = Told([picture(*seen)])
    assert SecondLook(detect=detect)(PICTURE) is detect.answers[0]


def test_a_panel_that_is_not_found_again_keeps_its_name() -> None:
    detect = Told([picture(("panel_up", 0.5, SMALL)), picture(("box", 0.9, LARGE))])
    assert SecondLook(detect=detect)(PICTURE) is detect.answers[0]
