"""A detector's score over sets of pictures: a pure function of their logs.

Average precision is a figure of all pictures together, not a mean over sets of them. So that a suite has an interval
and two detectors can be compared set by set, each set is given its share of the whole: shares whose mean is the figure
of all pictures, and whose spread is that of the jackknife (Efron and Tibshirani, An Introduction to the Bootstrap,
1993, chapter 11), which leaves one set out at a time.
"""

from collections.abc import Sequence
from statistics import fmean
from typing import NamedTuple

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
from adc_bench.world.frame import KEYPOINT_VISIBLE, Detections

CORNERS = 4


class PictureSet(NamedTuple):
    """Pictures, and what was found on each."""

    rows: tuple[DetectionRow, ...]
    found: tuple[Detections, ...]


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


class DetectionShare(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A set's shares of the figures of all pictures; none where there is no such figure."""

    map: float | None
    map50: float | None
    precision: float | None
    recall: float | None
    corner_error_px: float | None


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
    share: DetectionShare

    @property
    def failed(self) -> bool:
        """Whether the submission broke as a program."""
        return self.status in FAILED


def score_detections(logs: Sequence[DetectionLog], rules: Rules = RULES) -> tuple[DetectionEpisode, ...]:
    """Return the score of each run of a suite."""
    sets = [_set_of(log) for log in logs]
    together = _figures(sets, rules.believed_score)
    without = [_figures(sets[:k] + sets[k + 1 :], rules.believed_score) for k in range(len(sets))]
    shares = zip(*(_shares(together, without, name) for name in DetectionShare.__struct_fields__), strict=True)
    return tuple(
        _episode(log, one, DetectionShare(**dict(zip(DetectionShare.__struct_fields__, share, strict=True))), rules)
        for log, one, share in zip(logs, sets, shares, strict=True)
    )


def _shares(together: DetectionFigures, without: Sequence[DetectionFigures], name: str) -> list[float | None]:
    """Return each set's share of a figure, from that of all sets and those that leave one set out."""
    whole, left = getattr(together, name), [getattr(figures, name) for figures in without]
    if whole is None or len(left) < 2 or None in left:
        return [whole] * len(left)
    mean = fmean(left)
    return [whole + (len(left) - 1) * (mean - each) for each in left]


def _set_of(log: DetectionLog) -> PictureSet:
    """Return the pictures of a run with their answers; one that failed has found nothing."""
    answers = [() if log.ending.status in FAILED else row.answer or () for row in log.rows]
    return PictureSet(rows=log.rows, found=tuple(detections_of(answer) for answer in answers))


def _episode(log: DetectionLog, one: PictureSet, share: DetectionShare, rules: Rules) -> DetectionEpisode:
    labels = [row.labels for row in log.rows]
    return DetectionEpisode(
        scenario=log.header.scenario,
        seed=log.header.seed,
        status=log.ending.status,
        reason=log.ending.reason,
        pictures=len(log.rows),
        objects=sum(not label.ignore for of_picture in labels for label in of_picture),
        detection=_figures([one], rules.believed_score),
        share=share,
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


def _figures(sets: Sequence[PictureSet], believed: float) -> DetectionFigures:
    rows = [row for one in sets for row in one.rows]
    found = [answer for one in sets for answer in one.found]
    labels = [row.labels for row in rows]
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
