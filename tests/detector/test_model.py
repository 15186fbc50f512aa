import numpy as np
import torch

from adc_bench.detector.model import build_network, fused
from adc_bench.detector.note import ModelConfig
from adc_bench.detector.training.boxes import (
    boxes_to_distances,
    decode_boxes,
    distances_to_boxes,
    expected_distances,
    grid_points,
)
from adc_bench.world.categories import CATEGORIES


def test_the_network_answers_at_every_point_of_three_grids() -> None:
    network = build_network(ModelConfig(), len(CATEGORIES))
    points, strides = grid_points(256, 320)
    answers = network(torch.zeros(2, 3, 256, 320))
    assert len(points) == len(strides) == 40 * 32 + 20 * 16 + 10 * 8
    assert answers.object_logits.shape == (2, len(points))
    assert answers.class_logits.shape == (2, len(points), 21)
    assert answers.distance_logits.shape == (2, len(points), 4, 16)
    assert answers.keypoints.shape == (2, len(points), 4, 4)
    assert answers.corners.shape == (2, len(points), 4)
    assert sum(parameter.numel() for parameter in network.parameters()) * 4 < 4e6


def test_points_lie_where_the_features_look() -> None:
    """The answers that a change of one pixel changes lie around it: grids and maps are in the same order."""
    network = build_network(ModelConfig(), len(CATEGORIES)).eval()
    points, strides = grid_points(128, 160)
    before = torch.zeros(1, 3, 128, 160)
    after = before.clone()
    after[0, :, 84, 124] = 30.0
    with torch.no_grad():
        one, other = network(after), network(before)
    change = (one.class_logits - other.class_logits).square().sum(dim=(0, 2))
    corner_change = (one.corners - other.corners).square().sum(dim=(0, 2))
    for changed in (change, corner_change):
        for stride in (8, 16, 32):
            weight = changed[strides == stride]
            middle = weight @ points[strides == stride] / weight.sum()
            assert (middle - torch.tensor([124.5, 84.5])).abs().max() <= 1.5 * stride


def test_the_seed_decides_the_weights_and_leaves_the_random_state_alone() -> None:
    torch.manual_seed(5)
    expected = torch.rand(1)
    torch.manual_seed(5)
    one, same, other = (build_network(ModelConfig(), 21, seed).state_dict() for seed in (1, 1, 2))
    assert torch.rand(1) == expected
    assert all(torch.equal(one[name], same[name]) for name in one)
    assert not all(torch.equal(one[name], other[name]) for name in one)


def test_distances_and_boxes_are_inverse() -> None:
    generator = torch.Generator().manual_seed(0)
    points = torch.rand(50, 2, generator=generator) * 300
    boxes = torch.rand(50, 4, generator=generator) * 300
    assert torch.allclose(distances_to_boxes(points, boxes_to_distances(points, boxes)), boxes, atol=1e-4)


def test_a_certain_distribution_decodes_to_its_bin() -> None:
    points, strides = grid_points(32, 32)
    logits = torch.full((len(points), 4, 16), -50.0)
    logits[:, torch.arange(4), torch.tensor([1, 2, 3, 4])] = 50.0
    assert torch.allclose(expected_distances(logits), torch.tensor([1.0, 2.0, 3.0, 4.0]))
    finest = decode_boxes(logits, points, strides)[0]
    assert torch.allclose(finest, torch.tensor([4 - 8.0, 4 - 16.0, 4 + 24.0, 4 + 32.0]))


def test_folding_the_normalisation_changes_nothing() -> None:
    network = build_network(ModelConfig(), 21)
    x = torch.from_numpy(np.random.default_rng(0).normal(size=(2, 3, 64, 96)).astype(np.float32))
    network.train()(x)  # gives the normalisation statistics of its own
    with torch.no_grad():
        for ours, theirs in zip(fused(network)(x), network.eval()(x), strict=True):
            assert torch.allclose(ours, theirs, atol=1e-3, rtol=1e-3)
