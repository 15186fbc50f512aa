"""Which detection is of which object: greedy by score at overlap 0.50, category by category, as COCO does it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pycocotools import mask

from adc_bench.world.frame import Detections, Label

OVERLAP_MIN = 0.5
Integers = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Matches:
    """All objects and all detections of all pictures, in their order, and who belongs to whom.

    A detection takes the free object of its category that it overlaps most, the surest detection first, so that leaving
    out the detections below some score changes nothing for the others.

    Attributes:
        labels: the t labels, ignore regions among them.
        label_picture: (t,) the index of each label's picture.
        asked: (t,) whether the label is an object to be found, not a region to ignore.
        found_by: (t,) the detection of each label, -1 where there is none.
        picture: (d,) the index of each detection's picture.
        category_ids: (d,) from 1.
        scores: (d,).
        boxes_px: (d, 4) xyxy.
        keypoints_px: (d, 4, 2), with keypoint_sigma_px (d, 4) and keypoint_scores (d, 4).
        label: (d,) the object of each detection, -1 where there is none.
        counted: (d,) false for those on a region to ignore, which are neither right nor wrong.
    """

    pictures: int
    labels: Sequence[Label]
    label_picture: Integers
    asked: NDArray[np.bool_]
    found_by: Integers
    picture: Integers
    category_ids: Integers
    scores: NDArray[np.float32]
    boxes_px: NDArray[np.float32]
    keypoints_px: NDArray[np.float32]
    keypoint_sigma_px: NDArray[np.float32]
    keypoint_scores: NDArray[np.float32]
    label: Integers
    counted: NDArray[np.bool_]

    def found_score(self) -> NDArray[np.float32]:
        """Return (t,) the score with which each label was found, -1 where it was not."""
        scores: NDArray[np.float32] = np.append(self.scores, np.float32(-1))[self.found_by]
        return scores

    def wrong(self, threshold: float) -> NDArray[np.bool_]:
        """Return (d,) which detections at this score or above are of nothing."""
        wrong: NDArray[np.bool_] = (self.scores >= threshold) & self.counted & (self.label < 0)
        return wrong


def match(labels: Sequence[Sequence[Label]], found: Sequence[Detections]) -> Matches:
    """Return who belongs to whom on n pictures."""
    flat = [label for of_picture in labels for label in of_picture]
    label_first = np.cumsum([0, *map(len, labels)])
    found_first = np.cumsum([0, *(len(answer.scores) for answer in found)])
    asked = np.array([not label.ignore for label in flat], np.bool_)
    label = np.full(found_first[-1], -1, np.int64)
    counted = np.ones(found_first[-1], np.bool_)
    for k, (truth, answer) in enumerate(zip(labels, found, strict=True)):
        here = slice(found_first[k], found_first[k + 1])
        label[here], counted[here] = _match_picture(truth, answer)
        label[here] += np.where(label[here] >= 0, label_first[k], 0)
    found_by = np.full(len(flat), -1, np.int64)
    matched = np.flatnonzero(label >= 0)
    found_by[label[matched]] = matched
    return Matches(
        pictures=len(labels),
        labels=flat,
        label_picture=np.repeat(np.arange(len(labels)), np.diff(label_first)),
        asked=asked,
        found_by=found_by,
        picture=np.repeat(np.arange(len(found)), np.diff(found_first)),
        label=label,
        counted=counted,
        category_ids=_joined([answer.category_ids for answer in found], (0,), np.int64),
        scores=_joined([answer.scores for answer in found], (0,)),
        boxes_px=_joined([answer.boxes_px for answer in found], (0, 4)),
        keypoints_px=_joined([answer.keypoints_px for answer in found], (0, 4, 2)),
        keypoint_sigma_px=_joined([answer.keypoint_sigma_px for answer in found], (0, 4)),
        keypoint_scores=_joined([answer.keypoint_scores for answer in found], (0, 4)),
    )


def _match_picture(labels: Sequence[Label], found: Detections) -> tuple[Integers, NDArray[np.bool_]]:
    """Return for each detection of a picture its label, -1 for none, and whether it counts."""
    of, counted = np.full(len(found.scores), -1, np.int64), np.ones(len(found.scores), np.bool_)
    if len(labels) == 0 or len(of) == 0:
        return of, counted
    ignored = np.array([label.ignore for label in labels])
    overlap = mask.iou(_xywh(found.boxes_px), _xywh([label.box_px for label in labels]), ignored.astype(int).tolist())
    same = found.category_ids[:, None] == [label.category_id for label in labels]
    overlap = np.where(same, overlap, 0.0)
    free = ~ignored
    for k in np.argsort(-found.scores, kind="stable"):
        best = int(np.argmax(np.where(free, overlap[k], -1.0)))
        if free[best] and overlap[k, best] >= OVERLAP_MIN:
            of[k], free[best] = best, False
        else:
            counted[k] = not (overlap[k, ignored] >= OVERLAP_MIN).any()
    return of, counted


def _xywh(boxes: NDArray[np.float32] | Sequence[Sequence[float]]) -> NDArray[np.float64]:
    corners = np.asarray(boxes, np.float64)
    return np.concatenate([corners[:, :2], corners[:, 2:] - corners[:, :2]], axis=1)


def _joined(parts: Sequence[NDArray[Any]], empty: tuple[int, ...], kind: type = np.float32) -> NDArray[Any]:
    return np.concatenate([np.zeros(empty, kind), *parts]).astype(kind)
