from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from adc_bench.detector.evaluation import Evaluation
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.frame import NO_KEYPOINTS, BoxPx, Conditions, Detections, Label


@dataclass
class Labels:
    """Labels without pictures: what a score needs of a dataset."""

    labels: list[list[Label]]
    levels: tuple[str, ...] = ("dark", "bright")

    @property
    def image_ids(self) -> Sequence[int]:
        return [10 + i for i in range(len(self.labels))]

    def __len__(self) -> int:
        return len(self.labels)

    def picture(self, index: int) -> NDArray[np.uint8]:
        raise AssertionError("a score needs no pictures")

    def annotations(self, index: int) -> Sequence[Label]:
        return self.labels[index]

    def pose_world_camera(self, index: int) -> NDArray[np.float64]:
        return np.eye(4)

    def conditions(self, index: int) -> Conditions:
        level = self.levels[index % len(self.levels)]
        return Conditions(
            scenario="s",
            look_id="l",
            light_level=level,
            illuminance_lux=1.0,
            exposure=1.0,
            shutter_s=0.01,
            blur_px=0.0,
            in_tunnel=index == 0,
        )


def _label(name: str, box: BoxPx, *, ignore: bool = False) -> Label:
    return Label(
        category_id=CATEGORY_ID[name],
        instance=name,
        box_px=box,
        amodal_box_px=box,
        amodal_box_whole_px=box,
        mask_rle=b"",
        visible_px=100,
        visible_fraction=1.0,
        truncation=0.0,
        distance_m=1.0,
        pose_world_object=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        keypoints_px=NO_KEYPOINTS,
        ignore=ignore,
    )


def _found(*entries: tuple[str, float, BoxPx]) -> Detections:
    return Detections(
        boxes_px=np.array([box for _, _, box in entries], dtype=np.float32).reshape(-1, 4),
        scores=np.array([score for _, score, _ in entries], dtype=np.float32),
        category_ids=np.array([CATEGORY_ID[name] for name, _, _ in entries], dtype=np.int64),
        keypoints_px=np.zeros((len(entries), 4, 2), np.float32),
        keypoint_sigma_px=np.ones((len(entries), 4), np.float32),
        keypoint_scores=np.zeros((len(entries), 4), np.float32),
    )


A, B = (10.0, 10.0, 50.0, 50.0), (100.0, 100.0, 140.0, 140.0)
A_WIDE = (10.0, 10.0, 50.0, 60.0)  # overlaps A by 0.8: right at the overlaps 0.50 to 0.75, and at 0.80 itself


def test_two_found_of_two_is_one() -> None:
    score = Evaluation(
        Labels([[_label("crosswalk", A)], [_label("crosswalk", B)]]),
        [_found(("crosswalk", 0.9, A)), _found(("crosswalk", 0.8, B))],
    ).score()
    assert score.map == score.map50 == 1.0
    assert score.categories["crosswalk"].objects == 2 and list(score.categories) == ["crosswalk"]


def test_a_hand_made_case() -> None:
    """Ranked: right, wrong, right of three objects. Precision 1 up to recall 1/3, then 2/3 up to recall 2/3: of the 101
    recalls 34 lie up to 1/3 and 33 up to 2/3, so AP50 = (34 + 33 * 2/3) / 101.
    """
    truth = Labels([[_label("panel_up", A), _label("panel_up", B)], [_label("panel_up", A)]])
    found = [_found(("panel_up", 0.9, A), ("panel_up", 0.8, (200, 200, 220, 220))), _found(("panel_up", 0.7, A))]
    score = Evaluation(truth, found).score()
    assert score.map50 == pytest.approx((34 + 33 * 2 / 3) / 101, abs=1e-6)
    assert score.map == score.map50  # what is found is found exactly


def test_a_loose_box_counts_only_at_low_overlap() -> None:
    score = Evaluation(Labels([[_label("crosswalk", A)]]), [_found(("crosswalk", 0.9, A_WIDE))]).score()
    assert score.map50 == 1.0 and score.map == pytest.approx(0.7, abs=1e-6)


def test_ignored_regions_count_neither_way() -> None:
    truth = Labels([[_label("crosswalk", A), _label("crosswalk", B, ignore=True)]])
    found = [_found(("crosswalk", 0.95, (105, 105, 135, 135)), ("crosswalk", 0.9, A))]
    assert Evaluation(truth, found).score().categories["crosswalk"].ap == 1.0
    assert Evaluation(truth, [_found(("crosswalk", 0.9, A))]).score().categories["crosswalk"].objects == 1


def test_absent_categories_are_no_part_of_the_mean() -> None:
    truth = Labels([[_label("crosswalk", A), _label("panel_stop", B)]])
    score = Evaluation(truth, [_found(("crosswalk", 0.9, A), ("cone", 0.9, B))]).score()
    assert {name: entry.ap for name, entry in score.categories.items()} == {"crosswalk": 1.0, "panel_stop": 0.0}
    assert score.map == 0.5


def test_nothing_found_and_nothing_there() -> None:
    assert Evaluation(Labels([[_label("crosswalk", A)]]), [_found()]).score().map == 0.0
    assert Evaluation(Labels([[]]), [_found(("crosswalk", 0.9, A))]).score().categories == {}
