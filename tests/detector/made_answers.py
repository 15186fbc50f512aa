"""Labels and detections made by hand, and a dataset's truth as the answers of a perfect detector."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset import FrameDataset
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.corners_seen import keypoints_as_seen
from adc_bench.world.frame import KEYPOINT_VISIBLE, NO_KEYPOINTS, BoxPx, Conditions, Detections, Label


@dataclass
class Labels:
    """Labels without pictures: what a score needs of a dataset."""

    labels: list[list[Label]]

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
        return Conditions(
            scenario="s",
            look_id="l",
            light_level=("dark", "bright")[index % 2],
            illuminance_lux=1.0,
            exposure=1.0,
            shutter_s=0.01,
            blur_px=0.0,
            in_tunnel=index == 0,
        )


def label(name: str, box: BoxPx, *, ignore: bool = False, distance_m: float = 1.0) -> Label:
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
        distance_m=distance_m,
        pose_world_object=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        keypoints_px=NO_KEYPOINTS,
        ignore=ignore,
    )


def answer(*entries: tuple[str, float, BoxPx]) -> Detections:
    """Detections by name, score and box, without corners."""
    return Detections(
        boxes_px=np.array([box for _, _, box in entries], dtype=np.float32).reshape(-1, 4),
        scores=np.array([score for _, score, _ in entries], dtype=np.float32),
        category_ids=np.array([CATEGORY_ID[name] for name, _, _ in entries], dtype=np.int64),
        keypoints_px=np.zeros((len(entries), 4, 2), np.float32),
        keypoint_sigma_px=np.ones((len(entries), 4), np.float32),
        keypoint_scores=np.zeros((len(entries), 4), np.float32),
    )


def perfect_answers(source: FrameDataset, score: float = 0.9) -> list[Detections]:
    """The labels that count, as detections with their true corners."""
    answers = []
    for i in range(len(source)):
        asked = [one for one in source.annotations(i) if not one.ignore]
        keypoints = keypoints_as_seen(asked, towards_plus_x=source.pose_world_camera(i)[0, 2] > 0)
        answers.append(
            Detections(
                boxes_px=np.array([one.box_px for one in asked], np.float32).reshape(-1, 4),
                scores=np.full(len(asked), score, np.float32),
                category_ids=np.array([one.category_id for one in asked], np.int64),
                keypoints_px=keypoints[..., :2],
                keypoint_sigma_px=np.ones((len(asked), 4), np.float32),
                keypoint_scores=(keypoints[..., 2] == KEYPOINT_VISIBLE).astype(np.float32),
            )
        )
    return answers
