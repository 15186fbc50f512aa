import numpy as np
import pytest
import torch

from adc_bench.detector.boxes import (
    boxes_to_distances,
    decode_boxes,
    distances_to_boxes,
    expected_distances,
    grid_points,
    select,
)
from adc_bench.detector.model import ModelConfig, Prediction, build_network, prepare
from adc_bench.detector.predict import Detector, fused
from adc_bench.world.categories import CATEGORIES


def test_the_network_answers_at_every_point_of_three_grids() -> None:
    network = build_network(ModelConfig(), len(CATEGORIES))
    x = prepare(torch.zeros(2, 240, 320, 3, dtype=torch.uint8))
    assert x.shape == (2, 3, 256, 320)
    points, strides = grid_points(256, 320)
    answers = network(x)
    assert len(points) == len(strides) == 40 * 32 + 20 * 16 + 10 * 8
    assert answers.object_logits.shape == (2, len(points))
    assert answers.class_logits.shape == (2, len(points), 21)
    assert answers.distance_logits.shape == (2, len(points), 4, 16)
    assert sum(parameter.numel() for parameter in network.parameters()) * 4 < 4e6


def test_points_lie_where_the_features_look() -> None:
    """A change of one pixel changes most the answers of the points near it: grids and maps are in the same order."""
    network = build_network(ModelConfig(), len(CATEGORIES)).eval()
    points, strides = grid_points(128, 160)
    before = torch.zeros(1, 3, 128, 160)
    after = before.clone()
    after[0, :, 84, 124] = 30.0
    with torch.no_grad():
        change = (network(after).class_logits - network(before).class_logits).abs().sum(dim=(0, 2))
    for stride in (8, 16, 32):
        nearest = points[strides == stride][change[strides == stride].argmax()]
        assert (nearest - torch.tensor([124.5, 84.5])).abs().max() <= 1.5 * stride


def test_preparing_undoes_the_level_of_light() -> None:
    rng = np.random.default_rng(0)
    bright = torch.from_numpy(rng.integers(0, 120, (1, 64, 96, 3), dtype=np.uint8))
    one, other = prepare(bright), prepare(bright * 2 + 10)
    assert abs(float(one.mean())) < 1e-5
    assert float((one - other).abs().max()) < 0.15
    assert torch.isfinite(prepare(torch.zeros(1, 50, 70, 3, dtype=torch.uint8))).all()


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


def _answers(*entries: tuple[int, float, int, float]) -> tuple[Prediction, torch.Tensor, torch.Tensor]:
    """Answers on a 64x64 picture: (point, object logit, class, side distance in strides)."""
    points, strides = grid_points(64, 64)
    objects = torch.full((1, len(points)), -20.0)
    classes = torch.zeros(1, len(points), 21)
    distances = torch.full((1, len(points), 4, 16), -50.0)
    for point, logit, category, reach in entries:
        objects[0, point], classes[0, point, category] = logit, 20.0
        distances[0, point, :, int(reach)] = 50.0
    return Prediction(objects, classes, distances), points, strides


def _select(answers: tuple[Prediction, torch.Tensor, torch.Tensor], **options: float) -> tuple[torch.Tensor, ...]:
    settings = {"score_min": 0.25, "overlap_max": 0.6, "count_max": 100, **options}
    return select(answers[0], 0, answers[1], answers[2], size_px=(64, 60), **settings)  # type: ignore[arg-type]


def test_selection_drops_the_unlikely_and_the_double() -> None:
    # Points 18 and 27 are diagonal neighbours: their boxes of three strides overlap by (40/48)^2, 53 %.
    answers = _answers((27, 2.0, 0, 3), (26, 1.0, 0, 3), (29, 0.0, 4, 1), (60, -3.0, 1, 1))
    boxes, scores, classes = _select(answers)
    assert classes.tolist() == [0, 4]
    assert scores.tolist() == pytest.approx([0.8808, 0.5], abs=1e-3)
    assert boxes[0].tolist() == pytest.approx([4, 4, 52, 52])
    assert len(_select(answers, overlap_max=0.9)[0]) == 3
    assert len(_select(answers, score_min=0.01)[0]) == 3
    assert len(_select(answers, count_max=1)[0]) == 1


def test_boxes_end_at_the_picture_not_at_its_padding() -> None:
    boxes, _, _ = _select(_answers((63, 3.0, 0, 4)))
    assert boxes.tolist() == [[28.0, 28.0, 64.0, 60.0]]


def test_nothing_found_is_an_answer() -> None:
    boxes, scores, classes = _select(_answers())
    assert boxes.shape == (0, 4) and len(scores) == len(classes) == 0


def test_folding_the_normalisation_changes_nothing() -> None:
    network = build_network(ModelConfig(), 21)
    x = prepare(torch.from_numpy(np.random.default_rng(0).integers(0, 256, (2, 64, 96, 3), dtype=np.uint8)))
    network.train()(x)  # gives the normalisation statistics of its own
    with torch.no_grad():
        for ours, theirs in zip(fused(network)(x), network.eval()(x), strict=True):
            assert torch.allclose(ours, theirs, atol=1e-3, rtol=1e-3)


def test_a_detector_repeats_itself_whatever_stands_beside_a_picture() -> None:
    detector = Detector(build_network(ModelConfig(), 21), score_min=0.0, count_max=20)
    rng = np.random.default_rng(3)
    pictures = [rng.integers(0, 256, (120, 160, 3), dtype=np.uint8) for _ in range(3)]
    alone = detector(pictures[1])
    again = detector(pictures[1])
    assert np.array_equal(alone.boxes_px, again.boxes_px) and np.array_equal(alone.scores, again.scores)
    beside = detector.detect(pictures)[1]
    assert np.allclose(alone.scores, beside.scores, atol=1e-5)
    assert alone.boxes_px.dtype == np.float32 and alone.category_ids.dtype == np.int64
    assert alone.category_ids.min() >= 1 and (np.diff(alone.scores) <= 0).all()
