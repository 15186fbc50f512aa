"""The losses beside plain numpy, sum by sum."""

import math

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor

from adc_bench.detector.model import Prediction
from adc_bench.detector.training.boxes import decode_boxes, grid_points
from adc_bench.detector.training.loss import LOG_SCALE, LossConfig, detection_loss, distribution_loss, laplace_loss
from adc_bench.detector.training.targets import Truth, assign, centredness, corner_targets

POINTS, STRIDES = grid_points(64, 96)
NOTHING = Truth(
    torch.zeros(0, 4), torch.zeros(0, dtype=torch.long), torch.zeros(0, dtype=torch.bool), torch.zeros(0, 4, 3)
)
Array = NDArray[np.float64]


def random_prediction(seed: int, pictures: int) -> Prediction:
    generator = torch.Generator().manual_seed(seed)
    n = len(POINTS)
    shapes = ((n,), (n, 21), (n, 4, 16), (n, 4, 4), (n, 4))
    return Prediction(*(torch.randn(pictures, *shape, generator=generator) for shape in shapes))


def random_truth(seed: int) -> Truth:
    rng = np.random.default_rng(seed)
    low = rng.uniform(0, 60, (4, 2)) * (1, 0.5)
    boxes = np.concatenate([low, low + rng.uniform(6, 30, (4, 2))], axis=1)
    corners = boxes[:, [[0, 1], [2, 1], [2, 3], [0, 3]]]
    keypoints = np.concatenate([corners, rng.integers(0, 3, (4, 4, 1))], axis=2) * 1.0
    keypoints[keypoints[..., 2] == 0] = 0
    return Truth(
        torch.tensor(boxes, dtype=torch.float32),
        torch.tensor(rng.integers(0, 21, 4)),
        torch.tensor([False, False, False, True]),
        torch.tensor(keypoints, dtype=torch.float32),
    )


def log_sigmoid(x: float) -> float:
    return -math.log1p(math.exp(-x))


def cross_entropy(logits: Array, index: int) -> float:
    return float(np.log(np.exp(logits - logits.max()).sum()) + logits.max() - logits[index])


def complete_iou_loss(a: Array, b: Array) -> float:
    """1 - IoU + d^2 / c^2 + alpha v (Zheng et al., 2020)."""
    width, height = np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2])
    inter = max(width, 0) * max(height, 0)
    union = float(np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2]) - inter)
    around = np.maximum(a[2:], b[2:]) - np.minimum(a[:2], b[:2])
    apart = (a[:2] + a[2:] - b[:2] - b[2:]) / 2
    aspect_a, aspect_b = (math.atan((box[2] - box[0]) / (box[3] - box[1])) for box in (a, b))
    v = 4 / math.pi**2 * (aspect_b - aspect_a) ** 2
    overlap = inter / union
    return float(1 - overlap + (apart @ apart) / (around @ around) + v * v / (1 - overlap + v))


def slow_loss(prediction: Prediction, truths: list[Truth]) -> dict[str, float]:
    """Every part, point by point."""
    config, sums, total = LossConfig(), dict.fromkeys(LossConfig.__struct_fields__[:8], 0.0), 0.0
    near_count = 0
    for i, truth in enumerate(truths):
        objects, classes, distances, keypoints, corners = (part[i].double().numpy() for part in prediction)
        boxes = decode_boxes(prediction.distance_logits[i], POINTS, STRIDES)
        found = assign(config.assignment, truth, prediction.object_logits[i].sigmoid(), boxes, POINTS, STRIDES)
        kept = Truth(*(part[~truth.ignored] for part in truth))
        total += float(found.quality.sum())
        for p, (x, y) in enumerate(POINTS.numpy()):
            quality = float(found.quality[p])
            if found.counted[p]:
                sums["objects"] -= quality * log_sigmoid(objects[p]) + (1 - quality) * log_sigmoid(-objects[p])
            b = int(found.box_index[p])
            if b < 0:
                continue
            stride = float(STRIDES[p])
            box = kept.boxes[b].double().numpy()
            sums["classes"] += quality * cross_entropy(classes[p], int(kept.classes[b]))
            sums["overlap"] += quality * complete_iou_loss(boxes[p].double().numpy(), box)
            for side, away in enumerate(np.array([x - box[0], y - box[1], box[2] - x, box[3] - y]) / stride):
                away = min(max(away, 0), 15 - 0.01)
                low = int(away)
                for bin_, share in ((low, low + 1 - away), (low + 1, away - low)):
                    sums["distribution"] += quality * share * cross_entropy(distances[p, side], bin_) / 4
            for k, (u, v, state) in enumerate(kept.keypoints[b].double().numpy()):
                answer = keypoints[p, k]
                scale = float(np.clip(answer[2], *LOG_SCALE))
                away = abs(answer[0] - (u - x) / stride) + abs(answer[1] - (v - y) / stride)
                sums["keypoints"] += quality * (away / math.exp(scale) + 2 * scale) / 4 * (state > 0)
                sums["seen"] -= quality * log_sigmoid(answer[3] if state == 2 else -answer[3]) / 4
        seen = [(u, v) for b, points in enumerate(truth.keypoints.tolist()) for u, v, s in points
                if s == 2 and not truth.ignored[b]]  # fmt: skip
        other = [(u, v) for b, points in enumerate(truth.keypoints.tolist()) for u, v, s in points
                 if s == 1 or (s == 2 and truth.ignored[b])]  # fmt: skip
        for p, (x, y) in enumerate(POINTS.numpy()):
            stride = float(STRIDES[p])
            is_near, doubtful = (
                any(abs(x - u) < stride and abs(y - v) < stride for u, v in points) for points in (seen, other)
            )
            answer = corners[p]
            if is_near or not doubtful:
                sums["corners"] -= log_sigmoid(answer[0] if is_near else -answer[0])
            if is_near:
                u, v = min(seen, key=lambda corner: (corner[0] - x) ** 2 + (corner[1] - y) ** 2)
                scale = float(np.clip(answer[3], *LOG_SCALE))
                away = abs(answer[1] - (u - x) / stride) + abs(answer[2] - (v - y) / stride)
                sums["offsets"] += away / math.exp(scale) + 2 * scale
                near_count += 1
    return {
        name: value / max(near_count if name in ("corners", "offsets") else total, 1.0) for name, value in sums.items()
    }


@pytest.mark.parametrize("seed", range(4))
def test_every_part_agrees_with_the_slow_sum(seed: int) -> None:
    prediction, truths = random_prediction(seed, 2), [random_truth(10 * seed), random_truth(10 * seed + 1)]
    loss, parts = detection_loss(LossConfig(), prediction, truths, POINTS, STRIDES)
    slow = slow_loss(prediction, truths)
    for name, value in parts._asdict().items():
        assert float(value) == pytest.approx(slow[name], rel=2e-4, abs=2e-4), name
    assert float(loss) == pytest.approx(sum(getattr(LossConfig(), name) * slow[name] for name in slow), rel=2e-4)


def test_the_gradients_are_those_of_finite_differences() -> None:
    truth = random_truth(3)
    answers = random_prediction(3, 1)
    near = torch.tensor([[0.3, -0.2, 0.1]], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda x: laplace_loss(x, torch.tensor([[0.1, 0.4]])), near)
    logits = torch.randn(2, 4, 16, dtype=torch.float64, generator=torch.Generator().manual_seed(0), requires_grad=True)
    distances = torch.tensor([[0.3, 2.7, 14.2, 9.9], [1.5, 0.1, 3.3, 7.2]], dtype=torch.float64)
    assert torch.autograd.gradcheck(lambda x: distribution_loss(x, distances), logits)
    for part in answers:
        part.requires_grad_(True)
    detection_loss(LossConfig(), answers, [truth], POINTS, STRIDES)[0].backward()  # type: ignore[no-untyped-call]
    assert all(part.grad is not None and bool(torch.isfinite(part.grad).all()) for part in answers)


def test_the_distribution_loss_is_least_at_the_true_distance() -> None:
    distance = torch.tensor([[2.25, 0.0, 7.5, 14.9]])
    best = torch.full((1, 4, 16), -30.0)
    for side, (low, share) in enumerate([(2, 0.25), (0, 0.0), (7, 0.5), (14, 0.9)]):
        best[0, side, low] = torch.tensor(1 - share).log()
        best[0, side, low + 1] = torch.tensor(max(share, 1e-13)).log()
    least = distribution_loss(best, distance)
    generator = torch.Generator().manual_seed(0)
    for _ in range(20):
        assert distribution_loss(best + torch.randn(1, 4, 16, generator=generator) * 0.3, distance) > least
    entropy = torch.tensor([0.5623, 0.0, 0.6931, 0.3251]).mean()
    assert float(least) == pytest.approx(float(entropy), abs=2e-3)


def test_the_scale_that_costs_least_is_the_mean_error() -> None:
    errors = torch.from_numpy(np.random.default_rng(0).laplace(0.0, 0.3, (20000, 2)))
    costs = {
        scale: float(laplace_loss(torch.cat([errors, torch.full((20000, 1), math.log(scale))], 1), 0 * errors).mean())
        for scale in (0.15, 0.25, 0.3, 0.35, 0.6)
    }
    assert min(costs, key=costs.__getitem__) == 0.3


def _loss(truth: Truth, object_logits: Tensor) -> float:
    n = len(POINTS)
    quiet = torch.cat([torch.full((1, n, 1), -9.0), torch.zeros(1, n, 3)], dim=2)
    prediction = Prediction(
        object_logits, torch.zeros(1, n, 21), torch.zeros(1, n, 4, 16), torch.zeros(1, n, 4, 4), quiet
    )
    return float(detection_loss(LossConfig(), prediction, [truth], POINTS, STRIDES)[0])


def test_ignored_regions_cost_nothing() -> None:
    region = Truth(
        torch.tensor([[30.0, 30.0, 80.0, 60.0]]), torch.tensor([0]), torch.tensor([True]), torch.zeros(1, 4, 3)
    )
    quiet = torch.full((1, len(POINTS)), -9.0)
    alarmed = torch.where(centredness(POINTS, STRIDES, region.boxes)[0] > 0, 9.0, quiet)
    assert _loss(NOTHING, alarmed) > 100 * _loss(NOTHING, quiet)
    assert _loss(region, alarmed) <= _loss(NOTHING, quiet)


def test_every_seen_corner_has_the_four_points_around_it() -> None:
    truth = random_truth(5)
    found = corner_targets(truth, POINTS, STRIDES)
    for points in truth.keypoints[~truth.ignored].tolist():
        for u, v, state in points:
            if state == 2 and 4 < u < 92 and 4 < v < 60:
                around = ((POINTS - torch.tensor([u, v])).abs() < 8).all(dim=1) & (STRIDES == 8)
                assert around.sum() == 4 and found.is_near[around].all() and found.counted[around].all()
    nothing = corner_targets(NOTHING, POINTS, STRIDES)
    assert not nothing.is_near.any() and nothing.counted.all()
