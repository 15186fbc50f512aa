import itertools

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor
from torchvision.ops import box_iou

from adc_bench.detector.boxes import grid_points
from adc_bench.detector.loss import LossConfig, detection_loss, distribution_loss
from adc_bench.detector.model import Prediction
from adc_bench.detector.targets import FLOOR, MINIMUM_STRIDES, Assignment, AssignmentConfig, Truth, assign, centredness

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
    return Truth(boxes, torch.arange(count) % 21, ignored), scores, predicted


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
        truth = Truth(torch.tensor([[x, y, x + 1.0, y + 1.0]]), torch.tensor([0]), torch.tensor([False]))
        boxes = torch.cat([POINTS - 1, POINTS + 1], dim=1)
        assert (assign(CONFIG, truth, torch.full((len(POINTS),), 0.01), boxes, POINTS, STRIDES).box_index == 0).any()


def test_a_picture_without_objects_is_all_background() -> None:
    truth = Truth(torch.zeros(0, 4), torch.zeros(0, dtype=torch.long), torch.zeros(0, dtype=torch.bool))
    found = assign(CONFIG, truth, torch.rand(len(POINTS)), torch.rand(len(POINTS), 4), POINTS, STRIDES)
    assert isinstance(found, Assignment)
    assert (found.box_index == -1).all() and (found.quality == 0).all() and found.counted.all()


def test_the_distribution_loss_is_least_at_the_true_distance() -> None:
    distance = torch.tensor([[2.25, 0.0, 7.5, 14.9]])
    best = torch.full((1, 4, 16), -30.0)
    for side, (low, share) in enumerate([(2, 0.25), (0, 0.0), (7, 0.5), (14, 0.9)]):
        best[0, side, low] = torch.tensor(1 - share).log()
        best[0, side, low + 1] = torch.tensor(max(share, 1e-13)).log()
    least = distribution_loss(best, distance)
    for _ in range(20):
        assert distribution_loss(best + torch.randn(1, 4, 16) * 0.3, distance) > least
    entropy = torch.tensor([0.5623, 0.0, 0.6931, 0.3251]).mean()
    assert float(least) == pytest.approx(float(entropy), abs=2e-3)


def _loss(truth: Truth, object_logits: Tensor) -> float:
    classes, distances = torch.zeros(1, len(POINTS), 21), torch.zeros(1, len(POINTS), 4, 16)
    prediction = Prediction(object_logits, classes, distances)
    return float(detection_loss(LossConfig(), prediction, [truth], POINTS, STRIDES)[0])


def test_ignored_regions_cost_nothing() -> None:
    nothing = Truth(torch.zeros(0, 4), torch.zeros(0, dtype=torch.long), torch.zeros(0, dtype=torch.bool))
    region = Truth(torch.tensor([[30.0, 30.0, 80.0, 70.0]]), torch.tensor([0]), torch.tensor([True]))
    quiet = torch.full((1, len(POINTS)), -9.0)
    alarmed = torch.where(centredness(POINTS, STRIDES, region.boxes)[0] > 0, 9.0, quiet)
    assert _loss(nothing, alarmed) > 100 * _loss(nothing, quiet)
    assert _loss(region, alarmed) <= _loss(nothing, quiet)
