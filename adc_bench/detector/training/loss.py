"""The training loss: is there an object (as good as its box is), which, the box' overlap, its sides' distributions, its
corners; and where the nearest corner is.
"""

from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import torch
from torch import Tensor
from torch.nn import functional
from torchvision.ops import complete_box_iou_loss

from adc_bench.detector.model import Prediction
from adc_bench.detector.training.boxes import boxes_to_distances, decode_boxes
from adc_bench.detector.training.targets import (
    Assignment,
    AssignmentConfig,
    CornerTargets,
    Truth,
    assign,
    corner_targets,
)
from adc_bench.world.frame import KEYPOINT_OUTSIDE, KEYPOINT_VISIBLE

LOG_SCALE = (-4.0, 3.0)  # least and largest logarithm of a corner's deviation in strides


class LossConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How much each part weighs."""

    objects: float = 1.0
    classes: float = 2.0
    overlap: float = 5.0
    distribution: float = 1.0
    keypoints: float = 1.0
    seen: float = 0.5
    corners: float = 1.0
    offsets: float = 0.5
    assignment: AssignmentConfig = AssignmentConfig()


class Parts(NamedTuple):
    """The unweighted parts of a batch' loss, each a scalar."""

    objects: Tensor
    classes: Tensor
    overlap: Tensor
    distribution: Tensor
    keypoints: Tensor
    seen: Tensor
    corners: Tensor
    offsets: Tensor


def detection_loss(
    config: LossConfig, prediction: Prediction, truths: Sequence[Truth], points: Tensor, strides: Tensor
) -> tuple[Tensor, Parts]:
    """Return the loss of a batch and its parts.

    What is said of objects is a sum over points divided by the batch' total quality, what is said of corners nearby is
    divided by the number of points near one.
    """
    prediction = Prediction(*(part.float() for part in prediction))
    scores = prediction.object_logits.detach().sigmoid()
    boxes = decode_boxes(prediction.distance_logits, points, strides)
    found = [
        assign(config.assignment, truth, scores[i], boxes[i].detach(), points, strides)
        for i, truth in enumerate(truths)
    ]
    corners = [corner_targets(truth, points, strides) for truth in truths]
    near = CornerTargets(*(torch.stack(part) for part in zip(*corners, strict=True)))
    parts = Parts(
        *_object_parts(prediction, boxes, truths, found, points, strides),
        *_corner_parts(prediction.corners, near, points, strides),
    )
    return torch.stack([getattr(config, name) * part for name, part in parts._asdict().items()]).sum(), parts


def _object_parts(
    prediction: Prediction,
    boxes: Tensor,
    truths: Sequence[Truth],
    found: Sequence[Assignment],
    points: Tensor,
    strides: Tensor,
) -> list[Tensor]:
    positive, quality, counted = (
        torch.stack(parts) for parts in zip(*((a.box_index >= 0, a.quality, a.counted) for a in found), strict=True)
    )
    true_boxes = _gather([t.boxes[~t.ignored] for t in truths], found)
    true_classes = _gather([t.classes[~t.ignored] for t in truths], found)
    true_keypoints = _gather([t.keypoints[~t.ignored] for t in truths], found)
    at, weight = torch.nonzero(positive)[:, 1], quality[positive]
    true_distances = boxes_to_distances(points[at], true_boxes) / strides[at, None]
    true_offsets = (true_keypoints[..., :2] - points[at, None]) / strides[at, None, None]
    state, keypoints = true_keypoints[..., 2], prediction.keypoints[positive]
    located = laplace_loss(keypoints[..., :3], true_offsets) * (state != KEYPOINT_OUTSIDE)
    is_seen = (state == KEYPOINT_VISIBLE).to(keypoints.dtype)
    terms = (
        functional.binary_cross_entropy_with_logits(prediction.object_logits, quality, reduction="none") * counted,
        functional.cross_entropy(prediction.class_logits[positive], true_classes, reduction="none") * weight,
        complete_box_iou_loss(boxes[positive], true_boxes, reduction="none") * weight,
        distribution_loss(prediction.distance_logits[positive], true_distances) * weight,
        located.mean(dim=1) * weight,
        functional.binary_cross_entropy_with_logits(keypoints[..., 3], is_seen, reduction="none").mean(dim=1) * weight,
    )
    total = quality.sum().clamp(min=1.0)
    return [term.sum() / total for term in terms]


def _corner_parts(corners: Tensor, near: CornerTargets, points: Tensor, strides: Tensor) -> list[Tensor]:
    is_near = near.is_near.to(corners.dtype)
    terms = functional.binary_cross_entropy_with_logits(corners[..., 0], is_near, reduction="none") * near.counted
    offsets = ((near.corners - points) / strides[:, None])[near.is_near]
    located = laplace_loss(corners[near.is_near][:, 1:], offsets)
    total = is_near.sum().clamp(min=1.0)
    return [terms.sum() / total, located.sum() / total]


def laplace_loss(answers: Tensor, truth: Tensor) -> Tensor:
    """Return (...): the negative logarithm of a Laplace density, but for a constant, of points (..., 2) given answers
    (..., 3): u, v and the logarithm of the scale b of both; |du| / b + |dv| / b + 2 log b. After Li et al., "Human Pose
    Regression with Residual Log-likelihood Estimation", 2021, whose plain form this is.
    """
    log_scale = answers[..., 2].clamp(*LOG_SCALE)
    away = (answers[..., :2] - truth).abs().sum(dim=-1)
    return away * torch.exp(-log_scale) + 2 * log_scale


def distribution_loss(logits: Tensor, distances: Tensor) -> Tensor:
    """Return (k,): the cross entropy of distributions (k, 4, bins) to distances (k, 4) in strides, shared between the
    two nearest bins; the mean over the sides. After Li et al., "Generalized Focal Loss", 2020.
    """
    last = logits.shape[-1] - 1
    distances = distances.clamp(0, last - 0.01)
    low = distances.floor().long()
    share = distances - low
    log_p = logits.log_softmax(dim=-1)
    below = log_p.gather(-1, low[..., None]).squeeze(-1)
    above = log_p.gather(-1, low[..., None] + 1).squeeze(-1)
    return -(below * (1 - share) + above * share).mean(dim=-1)


def _gather(values: Sequence[Tensor], found: Sequence[Assignment]) -> Tensor:
    """Return the values of the boxes that the positive points of all pictures are assigned to, in the points' order."""
    return torch.cat([value[a.box_index[a.box_index >= 0]] for value, a in zip(values, found, strict=True)])
