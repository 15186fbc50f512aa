"""From the network's raw answers to detections: boxes, suppression of doubles, corners. Numpy and OpenCV alone."""

from functools import lru_cache
from typing import NamedTuple

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.world.frame import Detections

Array = NDArray[np.float32]
STRIDES = (8, 16, 32)
LAPLACE_SIGMA = 2**0.5  # the standard deviation of a Laplace density over its scale


class Answers(NamedTuple):
    """The network's raw answers for one picture at p points, as they leave its branches; lengths in strides.

    what (classes, p): class logits. where (1 + 4 bins, p): whether there is an object, a logit; how far its left, top,
    right and bottom side are, logits of distances 0, 1, 2 and so on. corners (4 + 16, p): of any object's corner nearby
    the logit that there is one, u and v to it, logarithm of the error's scale; of the object's four corners u, v,
    logarithm of the error's scale, logit of being seen.
    """

    what: Array
    where: Array
    corners: Array


class DecodeConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is kept: detections above `score_min`, of those of one class that overlap by more than `overlap_max`
    (intersection over union) the best, `count_max` at most; and how near to where an object expects a corner one must
    have been seen, in strides of the point that expects it, how surely, and how near to each other points must see it
    to be taken for one.
    """

    score_min: float = 0.4
    overlap_max: float = 0.6
    count_max: int = 100
    corner_reach_strides: float = 1.0
    corner_score_min: float = 0.3
    corner_merge_px: float = 4.0


TO_BE_SCORED = DecodeConfig(score_min=0.01)  # average precision needs the unlikely boxes too


def decode(config: DecodeConfig, answers: Answers, size_px: tuple[int, int]) -> Detections:
    """Return what is on a picture of `size_px` (width, height), best first; boxes are clipped to the picture."""
    points, strides = grid(*size_px)
    likely = np.flatnonzero(sigmoid(answers.where[0]) > config.score_min)
    scores = sigmoid(answers.where[0, likely, None]) * _softmax(answers.what[:, likely].T)
    row, category = np.nonzero(scores > config.score_min)
    scores, at = scores[row, category], likely[row]
    distances = answers.where[1:, at].reshape(4, len(answers.where) // 4, len(at)).transpose(2, 0, 1)
    boxes = np.clip(_boxes(distances, points[at], strides[at]), 0, np.array(2 * size_px, np.float32))
    kept = _without_doubles(config, boxes, scores, category)
    at = at[kept]
    keypoints = answers.corners[4:, at].reshape(4, 4, len(at)).transpose(2, 0, 1)
    corners, scale_px = _corners(config, keypoints, answers.corners[:4], points, strides, at)
    return Detections(
        boxes_px=boxes[kept],
        scores=scores[kept],
        category_ids=category[kept].astype(np.int64) + 1,
        keypoints_px=corners,
        keypoint_sigma_px=np.float32(LAPLACE_SIGMA) * scale_px,
        keypoint_scores=sigmoid(keypoints[..., 3]),
    )


@lru_cache(maxsize=4)
def grid(width_px: int, height_px: int) -> tuple[Array, Array]:
    """Return points (p, 2), x y in pixels, and their strides (p,) for a picture, padded as `prepare` does; points
    ordered by stride, then row, then column.
    """
    points, strides = [], []
    width, height = (side + -side % STRIDES[-1] for side in (width_px, height_px))
    for stride in STRIDES:
        y, x = np.mgrid[0 : height // stride, 0 : width // stride]
        points.append((np.stack([x, y], axis=-1).reshape(-1, 2) + 0.5) * stride)
        strides.append(np.full(x.size, stride))
    return np.concatenate(points).astype(np.float32), np.concatenate(strides).astype(np.float32)


def sigmoid(x: Array) -> Array:
    """Return 1 / (1 + exp(-x))."""
    return np.asarray(1 / (1 + np.exp(-x)), np.float32)


def _softmax(x: Array) -> Array:
    powers = np.exp(x - x.max(axis=-1, keepdims=True))
    return np.asarray(powers / powers.sum(axis=-1, keepdims=True), np.float32)


def _boxes(logits: Array, points: Array, strides: Array) -> Array:
    """Return boxes (k, 4) xyxy px: each side lies as far away as the mean of its distribution (k, 4, bins) says."""
    bins = np.arange(logits.shape[-1], dtype=np.float32)
    away = _softmax(logits) @ bins * strides[:, None]
    return np.concatenate([points - away[:, :2], points + away[:, 2:]], axis=1)


def _without_doubles(config: DecodeConfig, boxes: Array, scores: Array, category: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return which of k detections stay, best first."""
    if len(boxes) == 0:
        return np.zeros(0, np.intp)
    sides = np.concatenate([boxes[:, :2], boxes[:, 2:] - boxes[:, :2]], axis=1)
    found = cv2.dnn.NMSBoxesBatched(
        sides.tolist(), scores.tolist(), category.tolist(), config.score_min, config.overlap_max
    )
    kept = np.sort(np.asarray(found, np.intp))
    best: NDArray[np.intp] = kept[np.argsort(-scores[kept], kind="stable")][: config.count_max]
    return best


def _corners(
    config: DecodeConfig, keypoints: Array, near: Array, points: Array, strides: Array, at: NDArray[np.intp]
) -> tuple[Array, Array]:
    """Return the corners (k, 4, 2) of k objects in pixels and the scales (k, 4) of their errors.

    An object knows about where its corners are; the points nearby know exactly where some corner is. Of the corners
    that they are sure of, within reach of the expected place, the likeliest is taken, as the mean of what all points
    beside it say, weighted by certainty.
    """
    expected = points[at, None] + keypoints[..., :2] * strides[at, None, None]
    scale_px = np.exp(keypoints[..., 2]) * strides[at, None]
    sure = np.flatnonzero(near[0] > np.log(config.corner_score_min / (1 - config.corner_score_min)))
    if len(sure) == 0:
        return expected, scale_px
    places = points[sure] + near[1:3, sure].T * strides[sure, None]
    place_scale_px = np.exp(near[3, sure]) * strides[sure]
    certainty = sigmoid(near[0, sure]) / np.square(place_scale_px)
    away_px = np.linalg.norm(expected[:, :, None] - places, axis=-1)
    within = away_px < config.corner_reach_strides * strides[at, None, None]
    likely = within * certainty * np.exp(-away_px / scale_px[..., None])
    best = places[likely.argmax(axis=-1)]
    weight = certainty * (np.linalg.norm(best[:, :, None] - places, axis=-1) < config.corner_merge_px)
    total = weight.sum(axis=-1)
    mean, mean_scale_px = (weight @ places) / total[..., None], (weight @ place_scale_px) / total
    found = within.any(axis=-1)
    corners = np.where(found[..., None], mean, expected)
    return corners.astype(np.float32), np.where(found, mean_scale_px, scale_px).astype(np.float32)
