"""Boxes and the points that predict them: grids, distances to the four sides, suppression of doubles."""

import torch
from torch import Tensor
from torchvision.ops import batched_nms

from adc_bench.detector.model import STRIDES, Prediction


def grid_points(height_px: int, width_px: int, device: torch.device | str = "cpu") -> tuple[Tensor, Tensor]:
    """Return points (p, 2), x y in pixels, and their strides (p,) for a padded picture."""
    points, strides = [], []
    for stride in STRIDES:
        y = (torch.arange(height_px // stride, device=device) + 0.5) * stride
        x = (torch.arange(width_px // stride, device=device) + 0.5) * stride
        grid_y, grid_x = torch.meshgrid(y, x, indexing="ij")
        points.append(torch.stack([grid_x.flatten(), grid_y.flatten()], dim=1))
        strides.append(torch.full((grid_x.numel(),), float(stride), device=device))
    return torch.cat(points), torch.cat(strides)


def distances_to_boxes(points: Tensor, distances: Tensor) -> Tensor:
    """Return boxes (..., 4) xyxy from points (..., 2) and distances (..., 4) left, top, right, bottom, in px."""
    return torch.cat([points - distances[..., :2], points + distances[..., 2:]], dim=-1)


def boxes_to_distances(points: Tensor, boxes: Tensor) -> Tensor:
    """Return distances (..., 4) left, top, right, bottom from points (..., 2) to boxes (..., 4): the inverse."""
    return torch.cat([points - boxes[..., :2], boxes[..., 2:] - points], dim=-1)


def expected_distances(distance_logits: Tensor) -> Tensor:
    """Return the mean (..., 4) in strides of the distributions (..., 4, bins), whose bins stand for 0, 1, 2, ..."""
    bins = torch.arange(distance_logits.shape[-1], device=distance_logits.device, dtype=distance_logits.dtype)
    return distance_logits.softmax(dim=-1) @ bins


def decode_boxes(distance_logits: Tensor, points: Tensor, strides: Tensor) -> Tensor:
    """Return boxes (..., p, 4) xyxy in pixels from logits (..., p, 4, bins)."""
    return distances_to_boxes(points, expected_distances(distance_logits) * strides[:, None])


def select(
    prediction: Prediction,
    picture: int,
    points: Tensor,
    strides: Tensor,
    *,
    size_px: tuple[int, int],
    score_min: float,
    overlap_max: float,
    count_max: int,
) -> tuple[Tensor, Tensor, Tensor]:
    """Return one picture's boxes (k, 4), scores (k,) and class indices (k,), best first.

    Boxes are clipped to the picture of `size_px` (width, height). Of boxes of one class that overlap by more than
    `overlap_max` (intersection over union) the best stays. Only points above `score_min` are decoded.
    """
    one = Prediction(*(part[picture] for part in prediction))
    likely = torch.nonzero(one.object_logits.sigmoid() > score_min).squeeze(1)
    one, points, strides = Prediction(*(part[likely] for part in one)), points[likely], strides[likely]
    scores = one.scores()
    point, category = torch.nonzero(scores > score_min, as_tuple=True)
    scores = scores[point, category]
    boxes = decode_boxes(one.distance_logits, points, strides)[point]
    boxes = boxes.clamp(min=0).minimum(boxes.new_tensor([*size_px, *size_px]))
    keep = batched_nms(boxes, scores, category, overlap_max)[:count_max]
    return boxes[keep], scores[keep], category[keep]
