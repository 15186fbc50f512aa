"""A detector's score over a set of pictures: a pure function of its log."""

from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.api import Detection
from adc_bench.detector.evaluation.matching import Matches, match
from adc_bench.detector.evaluation.score import CategoryScore, CocoScorer
from adc_bench.evaluate.ending import FAILED, Reason, Status
from adc_bench.evaluate.log import DetectionLog
from adc_bench.evaluate.recorded_log import DetectionRow
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.geometry import Pose3
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.corners_seen import keypoints_as_seen
from adc_bench.world.frame import KEYPOINT_VISIBLE, Detections, Label

CORNERS = 4


class DetectionFigures(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How good the answers to a set of pictures are.

    Attributes:
        map: average precision over overlaps 0.50 to 0.95 as COCO has it, the mean over the categories that occur.
        map50: the same at overlap 0.50.
        precision: of the detections that the rules believe (`Rules.believed_score`), the share that is right; none
            without any.
        recall: the share of the objects that those find.
        corner_error_px: mean distance of their corners from the true ones that are seen; none without any.
    """

    map: float
    map50: float
    precision: float | None
    recall: float | None
    corner_error_px: float | None
    categories: dict[str, CategoryScore]


class DetectionEpisode(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="detector"
):
    """The score of one set of pictures. One that `failed` has found nothing."""

    scenario: str
    seed: int
    status: Status
    reason: Reason
    pictures: int
    objects: int  # that were to be found
    detection: DetectionFigures

    @property
    def failed(self) -> bool:
        """Whether the submission broke as a program."""
        return self.status in FAILED


def score_detection(log: DetectionLog, rules: Rules = RULES) -> DetectionEpisode:
    """Return the score of a run."""
    labels = [row.labels for row in log.rows]
    answers = [() if log.ending.status in FAILED else row.answer or () for row in log.rows]
    found = [detections_of(answer) for answer in answers]
    return DetectionEpisode(
        scenario=log.header.scenario,
        seed=log.header.seed,
        status=log.ending.status,
        reason=log.ending.reason,
        pictures=len(log.rows),
        objects=sum(not label.ignore for of_picture in labels for label in of_picture),
        detection=_figures(log.rows, labels, found, rules.believed_score),
    )


def detections_of(answer: Sequence[Detection]) -> Detections:
    """Return an answer as arrays, best first; corners that were not given are not finite."""
    ordered = sorted(answer, key=lambda detection: -detection.score)
    corners = [each.corners_px or ((np.nan, np.nan),) * CORNERS for each in ordered]
    return Detections(
        boxes_px=np.array([each.box_px for each in ordered], dtype=np.float32).reshape(-1, 4),
        scores=np.array([each.score for each in ordered], dtype=np.float32),
        category_ids=np.array([CATEGORY_ID[each.category] for each in ordered], dtype=np.int64),
        keypoints_px=np.array(corners, dtype=np.float32).reshape(-1, CORNERS, 2),
        keypoint_sigma_px=np.ones((len(ordered), CORNERS), np.float32),
        keypoint_scores=np.ones((len(ordered), CORNERS), np.float32),
    )


def _figures(
    rows: Sequence[DetectionRow], labels: Sequence[Sequence[Label]], found: Sequence[Detections], believed: float
) -> DetectionFigures:
    score = CocoScorer(range(len(rows)), labels, found).score()
    matches = match(labels, found)
    right = int(((matches.scores >= believed) & (matches.label >= 0)).sum())
    shown, asked = right + int(matches.wrong(believed).sum()), int(matches.asked.sum())
    return DetectionFigures(
        map=score.map,
        map50=score.map50,
        precision=right / shown if shown else None,
        recall=right / asked if asked else None,
        corner_error_px=_corner_error_px(rows, matches, believed),
        categories=score.categories,
    )


def _corner_error_px(rows: Sequence[DetectionRow], matches: Matches, believed: float) -> float | None:
    label = np.flatnonzero(matches.asked & (matches.found_score() >= believed))
    true = _true_corners(rows)[label]
    error_px = np.linalg.norm(matches.keypoints_px[matches.found_by[label]] - true[..., :2], axis=-1)
    seen = error_px[(true[..., 2] == KEYPOINT_VISIBLE) & np.isfinite(error_px)]
    return float(seen.mean(dtype=np.float64)) if seen.size else None


def _true_corners(rows: Sequence[DetectionRow]) -> NDArray[np.float32]:
    """Return the keypoints of all labels (t, 4, 3) in the order in which a detector tells them."""
    each = [
        keypoints_as_seen(row.labels, towards_plus_x=Pose3.from_figures(row.pose_world_camera).rotation[0, 2] > 0)
        for row in rows
    ]
    return np.concatenate([np.zeros((0, CORNERS, 3), np.float32), *each])
