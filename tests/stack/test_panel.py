from dataclasses import replace

import numpy as np
import pytest

from adc_bench.stack.panel import PanelReading, read_panel, uncut
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.frame import Detections
from adc_bench.world.sensors import SensorRig


def picture(*seen: tuple[str, float]) -> Detections:
    return Detections(
        boxes_px=np.zeros((len(seen), 4), dtype=np.float32),
        scores=np.array([score for _, score in seen], dtype=np.float32),
        category_ids=np.array([CATEGORY_ID[name] for name, _ in seen], dtype=np.int64),
        keypoints_px=np.zeros((len(seen), 4, 2), dtype=np.float32),
        keypoint_sigma_px=np.ones((len(seen), 4), dtype=np.float32),
        keypoint_scores=np.zeros((len(seen), 4), dtype=np.float32),
    )


def test_a_panel_that_a_side_of_the_picture_cuts_off_is_not_read() -> None:
    mount = SensorRig().camera("panel")
    seen = replace(
        picture(("panel_left", 0.9), ("panel_right", 0.8), ("panel_up", 0.5)),
        boxes_px=np.array([[302, 140, 320, 155], [0, 140, 20, 155], [140, 140, 170, 155]], dtype=np.float32),
    )
    np.testing.assert_array_equal(uncut(seen, mount).category_ids, [CATEGORY_ID["panel_up"]])
    assert uncut(seen, mount).scores == pytest.approx([0.5])


def reading_after(*pictures: Detections) -> PanelReading:
    reading = PanelReading()
    for detections in pictures:
        reading = read_panel(reading, detections)
    return reading


UP, STOP, NOTHING = picture(("panel_up", 0.9)), picture(("panel_stop", 0.9)), picture()


def test_a_sign_counts_when_seen_twice_running() -> None:
    assert reading_after(UP).sign is None
    assert reading_after(UP, UP).sign == "up"
    assert reading_after(UP, NOTHING, UP).sign is None
    assert reading_after(UP, STOP, UP).sign is None


def test_one_wrong_picture_does_not_replace_a_sign() -> None:
    assert reading_after(STOP, STOP, UP, STOP).sign == "stop"
    assert reading_after(STOP, STOP, UP, UP).sign == "up"
    assert reading_after(UP, UP, NOTHING, NOTHING).sign == "up"


def test_weak_and_other_detections_do_not_count() -> None:
    weak, other = picture(("panel_up", 0.2)), picture(("crosswalk", 0.9), ("sign_parking", 0.9))
    assert reading_after(weak, weak).sign is None
    assert reading_after(other, other).sign is None


def test_the_best_scoring_sign_is_taken_past_other_things() -> None:
    mixed = picture(("crosswalk", 0.95), ("panel_up", 0.9), ("panel_stop", 0.6))
    assert reading_after(mixed, mixed).sign == "up"
