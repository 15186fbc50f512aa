"""Boxes and the points that predict them: grids, distances to the four sides."""

import torch
from torch import Tensor

from adc_bench.detector.decode import STRIDES


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
