import itertools

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor
from torchvision.ops import box_iou

from adc_bench.detector.training.boxes import grid_points
from adc_bench.detector.training.targets import (
    FLOOR,
    MINIMUM_STRIDES,
    Assignment,
    AssignmentConfig,
    Truth,
    assign,
    centredness,
)

POINTS, STRIDES = grid_points(96, 128)
CONFIG = AssignmentConfig(points_per_box=5)


def _random_case(seed: int, count: int) -> tuple[Truth, Tensor, Tensor]:
    generator = torch.Generator().manual_seed(seed)
    corner = torch.rand(count, 2, generator=generator) * torch.tensor([100.0, 70.0])
    size = 4 + torch.rand(count, 2, generator=generator) * 40
    boxes = torch.cat([corner, corner + size], dim=1)
    ignored = torch.rand(count, generator=generator) < 0.2
    near = boxes[torch.randint(count, (len(POINTS),), generator=generator)]
    predicted = near + torch.randn(near.shape, generator=generator) * 6
    predicted = torch.cat([predicted[:, :2], torch.maximum(predicted[:, 2:], predicted[:, :2] + 1)], dim=1)
    scores = torch.rand(len(POINTS), generator=generator)
    return Truth(boxes, torch.arange(count) % 21, ignored, torch.zeros(count, 4, 3)), scores, predicted


def _slow_assign(truth: Truth, scores: Tensor, boxes: Tensor) -> tuple[list[int], list[float]]:
    """The same rule, point by point and box by box."""
    wanted = truth.boxes[~truth.ignored].tolist()
    index, best_overlap = [-1] * len(POINTS), [-1.0] * len(POINTS)
    overlap = box_iou(truth.boxes[~truth.ignored], boxes).tolist()
    alignments: list[dict[int, float]] = []
    for b, box in enumerate(wanted):
        found = {}
        for p, (x, y) in enumerate(POINTS.tolist()):
            least = float(STRIDES[p]) * MINIMUM_STRIDES / 2
            half_x, half_y = max((box[2] - box[0]) / 2, least), max((box[3] - box[1]) / 2, least)
            off_x, off_y = abs(x - (box[0] + box[2]) / 2) / half_x, abs(y - (box[1] + box[3]) / 2) / half_y
            if off_x < 1 and off_y < 1:
                found[p] = float(scores[p]) ** 0.5 * overlap[b][p] ** 6 + FLOOR * (1 - off_x) * (1 - off_y)
        alignments.append({p: found[p] for p in sorted(found, key=lambda p: -found[p])[: CONFIG.points_per_box]})
    for b, p in itertools.chain.from_iterable(((b, p) for p in found) for b, found in enumerate(alignments)):
        if overlap[b][p] > best_overlap[p]:
            index[p], best_overlap[p] = b, overlap[b][p]
    quality = [0.0] * len(POINTS)
    for b, found in enumerate(alignments):
        own = [p for p in found if index[p] == b]
        for p in own:
            scale = max(overlap[b][q] for q in own) / max(found[q] for q in own)
            quality[p] = found[p] * scale
    return index, quality


@given(seed=st.integers(0, 10**6), count=st.integers(1, 6))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_assignment_agrees_with_the_slow_one(seed: int, count: int) -> None:
    truth, scores, boxes = _random_case(seed, count)
    fast = assign(CONFIG, truth, scores, boxes, POINTS, STRIDES)
    index, quality = _slow_assign(truth, scores, boxes)
    assert fast.quality.tolist() == pytest.approx(quality, abs=1e-5)
    assert fast.box_index.tolist() == index


@given(seed=st.integers(0, 10**6), count=st.integers(1, 6))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_assignment_keeps_its_promises(seed: int, count: int) -> None:
    truth, scores, boxes = _random_case(seed, count)
    found = assign(CONFIG, truth, scores, boxes, POINTS, STRIDES)
    positive = found.box_index >= 0
    wanted = truth.boxes[~truth.ignored]
    assert found.quality.min() >= 0 and found.quality.max() <= 1
    assert (found.quality[~positive] == 0).all() and found.counted[positive].all()
    assert (torch.bincount(found.box_index[positive], minlength=1) <= CONFIG.points_per_box).all()
    inner = centredness(POINTS, STRIDES, wanted) > 0
    assert all(bool(inner[found.box_index[p], p]) for p in torch.nonzero(positive).flatten())
    hidden = (centredness(POINTS, STRIDES, truth.boxes[truth.ignored]) > 0).any(dim=0)
    assert torch.equal(found.counted, ~hidden | positive)


def test_even_the_smallest_box_gets_a_point() -> None:
    for x, y in itertools.product(range(20, 29), range(20, 29)):
        box = torch.tensor([[x, y, x + 1.0, y + 1.0]])
        truth = Truth(box, torch.tensor([0]), torch.tensor([False]), torch.zeros(1, 4, 3))
        boxes = torch.cat([POINTS - 1, POINTS + 1], dim=1)
        assert (assign(CONFIG, truth, torch.full((len(POINTS),), 0.01), boxes, POINTS, STRIDES).box_index == 0).any()


def test_a_picture_without_objects_is_all_background() -> None:
    nobody = torch.zeros(0, dtype=torch.bool)
    truth = Truth(torch.zeros(0, 4), torch.zeros(0, dtype=torch.long), nobody, torch.zeros(0, 4, 3))
    found = assign(CONFIG, truth, torch.rand(len(POINTS)), torch.rand(len(POINTS), 4), POINTS, STRIDES)
    assert isinstance(found, Assignment)
    assert (found.box_index == -1).all() and (found.quality == 0).all() and found.counted.all()
