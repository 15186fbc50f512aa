"""Who predicts what: points are assigned to true boxes by how well they already predict them (task alignment).

After Feng et al., "TOOD: Task-aligned One-stage Object Detection", 2021: alignment = score^a * overlap^b.
"""

from typing import NamedTuple

import msgspec
import torch
from torch import Tensor
from torchvision.ops import box_iou

from adc_bench.world.frame import KEYPOINT_VISIBLE

FLOOR = 1e-7
MINIMUM_STRIDES = 1.5  # a box smaller than this many strides is widened to it, or it might hold no point


class AssignmentConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Points per box, and the powers of score and overlap in the alignment."""

    points_per_box: int = 10
    score_power: float = 0.5
    overlap_power: float = 6.0


class Truth(NamedTuple):
    """One picture's truth: boxes (m, 4) xyxy px, classes (m,) from 0, ignored (m,) bool, keypoints (m, 4, 3): u, v px
    and the state, 0 where there is none.
    """

    boxes: Tensor
    classes: Tensor
    ignored: Tensor
    keypoints: Tensor


class Assignment(NamedTuple):
    """One picture's targets: box_index (p,), -1 where there is none; quality (p,) in [0, 1]; counted (p,) bool, false
    where the truth does not say what is there.
    """

    box_index: Tensor
    quality: Tensor
    counted: Tensor


class CornerTargets(NamedTuple):
    """What one picture's corners ask of points: is_near (p,) whether a seen corner is near, the nearest one (p, 2) px,
    counted (p,) false where a corner is near that nobody can see.
    """

    is_near: Tensor
    corners: Tensor
    counted: Tensor


@torch.no_grad()
def assign(
    config: AssignmentConfig, truth: Truth, scores: Tensor, boxes: Tensor, points: Tensor, strides: Tensor
) -> Assignment:
    """Return the targets for predicted object scores (p,) and boxes (p, 4); indices refer to the boxes that count.

    A box gets the best-aligned `points_per_box` of the points inside it; a point wanted by several goes to the one that
    it overlaps most. Quality is the alignment scaled so that a box' best point gets the best overlap.
    """
    regions = truth.boxes[truth.ignored]
    counted = ~(centredness(points, strides, regions) > 0).any(dim=0)
    wanted = truth.boxes[~truth.ignored]
    if len(wanted) == 0:
        return Assignment(torch.full_like(strides, -1, dtype=torch.long), torch.zeros_like(strides), counted)
    overlap = box_iou(wanted, boxes).clamp(min=0)
    centred = centredness(points, strides, wanted)
    candidate = centred > 0
    alignment = scores.pow(config.score_power) * overlap.pow(config.overlap_power)
    # The small addition lets a box choose its middle while nothing overlaps it yet.
    alignment = (alignment + FLOOR * centred) * candidate
    best = alignment.topk(min(config.points_per_box, alignment.shape[1]), dim=1).indices
    chosen = torch.zeros_like(candidate).scatter_(1, best, True) & candidate
    box_index = torch.where(chosen, overlap, -1.0).argmax(dim=0)
    positive = chosen.any(dim=0)
    chosen &= box_index == torch.arange(len(wanted), device=points.device)[:, None]
    alignment, overlap = alignment * chosen, overlap * chosen
    scale = overlap.amax(dim=1) / alignment.amax(dim=1).clamp(min=1e-12)
    quality = (alignment * scale[:, None]).amax(dim=0)
    return Assignment(torch.where(positive, box_index, -1), quality, counted | positive)


def centredness(points: Tensor, strides: Tensor, boxes: Tensor) -> Tensor:
    """Return (m, p): 1 for a point at the centre of a box, falling to 0 at its edge and outside; boxes (m, 4) are
    widened to at least `MINIMUM_STRIDES` of the point's stride.
    """
    centre = (boxes[:, None, :2] + boxes[:, None, 2:]) / 2
    half = (boxes[:, None, 2:] - boxes[:, None, :2]) / 2
    half = half.maximum(strides[None, :, None] * MINIMUM_STRIDES / 2)
    return (1 - (points[None] - centre).abs() / half).clamp(min=0).prod(dim=2)


@torch.no_grad()
def corner_targets(truth: Truth, points: Tensor, strides: Tensor) -> CornerTargets:
    """Return what a picture's corners ask of points (p, 2) of grids with strides (p,)."""
    states = truth.keypoints[..., 2].flatten()
    at = truth.keypoints[..., :2].reshape(-1, 2)
    is_seen = (states == KEYPOINT_VISIBLE) & ~truth.ignored.repeat_interleave(4)
    seen = at[is_seen]
    doubtful = _is_near(points, strides, at[(states > 0) & ~is_seen]).any(dim=1)
    if len(seen) == 0:
        return CornerTargets(torch.zeros_like(doubtful), torch.zeros_like(points), ~doubtful)
    nearest = (points[:, None] - seen).square().sum(dim=2).argmin(dim=1)
    near = _is_near(points, strides, seen).any(dim=1)
    return CornerTargets(near, seen[nearest], near | ~doubtful)


def _is_near(points: Tensor, strides: Tensor, corners: Tensor) -> Tensor:
    """Return (p, k): whether points (p, 2) lie within a stride of corners (k, 2) along both axes, so that every corner
    has the four points of each grid around it.
    """
    return ((points[:, None] - corners).abs() < strides[:, None, None]).all(dim=2)
