"""The training loss: is there an object (as good as its box is), which, the box' overlap, its sides' distributions."""

from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import torch
from torch import Tensor
from torch.nn import functional
from torchvision.ops import complete_box_iou_loss

from adc_bench.detector.boxes import boxes_to_distances, decode_boxes
from adc_bench.detector.model import Prediction
from adc_bench.detector.targets import Assignment, AssignmentConfig, Truth, assign


class LossConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How much each part weighs."""

    objects: float = 1.0
    classes: float = 2.0
    overlap: float = 5.0
    distribution: float = 1.0
    assignment: AssignmentConfig = AssignmentConfig()


class Parts(NamedTuple):
    """The unweighted parts of a batch' loss, each a scalar."""

    objects: Tensor
    classes: Tensor
    overlap: Tensor
    distribution: Tensor


def detection_loss(
    config: LossConfig, prediction: Prediction, truths: Sequence[Truth], points: Tensor, strides: Tensor
) -> tuple[Tensor, Parts]:
    """Return the loss of a batch and its parts; each part is a sum over points divided by the batch' total quality."""
    objects, classes, distances = (part.float() for part in prediction)
    scores, boxes = objects.detach().sigmoid(), decode_boxes(distances, points, strides)
    found = [
        assign(config.assignment, truth, scores[i], boxes[i].detach(), points, strides)
        for i, truth in enumerate(truths)
    ]
    positive, quality, counted = (
        torch.stack(parts) for parts in zip(*((a.box_index >= 0, a.quality, a.counted) for a in found), strict=True)
    )
    true_boxes = _gather([t.boxes[~t.ignored] for t in truths], found)
    true_classes = _gather([t.classes[~t.ignored] for t in truths], found)
    at, weight = torch.nonzero(positive)[:, 1], quality[positive]
    true_distances = boxes_to_distances(points[at], true_boxes) / strides[at, None]

    object_terms = functional.binary_cross_entropy_with_logits(objects, quality, reduction="none") * counted
    class_terms = functional.cross_entropy(classes[positive], true_classes, reduction="none") * weight
    overlap_terms = complete_box_iou_loss(boxes[positive], true_boxes, reduction="none") * weight
    distribution_terms = distribution_loss(distances[positive], true_distances) * weight
    total = quality.sum().clamp(min=1.0)
    parts = Parts(*(terms.sum() / total for terms in (object_terms, class_terms, overlap_terms, distribution_terms)))
    weights = (config.objects, config.classes, config.overlap, config.distribution)
    return torch.stack([w * part for w, part in zip(weights, parts, strict=True)]).sum(), parts


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
