import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from torchvision.ops import batched_nms

from adc_bench.detector.decode import Answers, DecodeConfig, decode, grid
from adc_bench.detector.training.boxes import decode_boxes, grid_points
from adc_bench.world.frame import Detections

SIZE_PX = (64, 60)
POINTS, STRIDES = grid(*SIZE_PX)
CONFIG = DecodeConfig()


def empty() -> Answers:
    """Answers on a 64x60 picture that see nothing."""
    answers = Answers(*(np.zeros((channels, len(POINTS)), np.float32) for channels in (21, 1 + 4 * 16, 4 + 16)))
    answers.where[0] = answers.corners[0] = -20
    answers.where[1:] = -50
    return answers


def answers(*entries: tuple[int, float, int, int]) -> Answers:
    """(point, object logit, class, side distance in strides)."""
    found = empty()
    for point, logit, category, reach in entries:
        found.where[0, point], found.what[category, point] = logit, 20.0
        found.where[1 + reach :: 16, point] = 50.0
    return found


def own_corner(given_answers: Answers, point: int, corner: int) -> NDArray[np.float32]:
    """What a point says of a corner of its object: u, v, logarithm of the scale, logit."""
    return given_answers.corners[4 + 4 * corner : 8 + 4 * corner, point]


def found(given_answers: Answers, **changes: float) -> Detections:
    return decode(DecodeConfig(**{"score_min": 0.25, **changes}), given_answers, SIZE_PX)  # type: ignore[arg-type]


@pytest.mark.parametrize("size_px", [(64, 60), (320, 240), (33, 1)])
def test_the_grid_is_that_of_training(size_px: tuple[int, int]) -> None:
    width, height = (-(-side // 32) * 32 for side in size_px)
    points, strides = grid_points(height, width)
    assert np.array_equal(grid(*size_px)[0], points.numpy())
    assert np.array_equal(grid(*size_px)[1], strides.numpy())


def test_the_unlikely_and_the_double_are_dropped() -> None:
    # Points 18 and 27 are diagonal neighbours: their boxes of three strides overlap by (40/48)^2, 53 %.
    several = answers((27, 2.0, 0, 3), (26, 1.0, 0, 3), (29, 0.0, 4, 1), (60, -3.0, 1, 1))
    one = found(several)
    assert one.category_ids.tolist() == [1, 5]
    assert one.scores.tolist() == pytest.approx([0.8808, 0.5], abs=1e-3)
    assert one.boxes_px[0].tolist() == pytest.approx([4, 4, 52, 52])
    assert len(found(several, overlap_max=0.9).scores) == 3
    assert len(found(several, score_min=0.01).scores) == 3
    assert len(found(several, count_max=1).scores) == 1


def test_boxes_end_at_the_picture_not_at_its_padding() -> None:
    assert found(answers((63, 3.0, 0, 4))).boxes_px.tolist() == [[28.0, 28.0, 64.0, 60.0]]


def test_nothing_found_is_an_answer() -> None:
    nothing = found(empty())
    assert nothing.boxes_px.shape == (0, 4) and len(nothing.scores) == len(nothing.category_ids) == 0
    assert nothing.keypoints_px.shape == (0, 4, 2) and nothing.keypoint_sigma_px.shape == (0, 4)
    assert nothing.keypoint_scores.shape == (0, 4)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_boxes_and_what_stays_of_them_agree_with_torch(seed: int) -> None:
    rng = np.random.default_rng(seed)
    some = Answers(*(rng.normal(0, 2, part.shape).astype(np.float32) for part in empty()))
    one = found(some, score_min=0.1, overlap_max=0.4)
    what, where = torch.from_numpy(some.what), torch.from_numpy(some.where)
    distances = where[1:].T.reshape(-1, 4, 16)
    scores = where[0].sigmoid()[:, None] * what.T.softmax(dim=1)
    row, category = torch.nonzero(scores > 0.1, as_tuple=True)
    boxes = decode_boxes(distances, torch.from_numpy(POINTS), torch.from_numpy(STRIDES))[row]
    boxes = boxes.clamp(min=0).minimum(torch.tensor([64.0, 60.0, 64.0, 60.0]))
    kept = batched_nms(boxes, scores[row, category], category, 0.4)[:100]
    assert np.allclose(one.scores, scores[row, category][kept], atol=1e-6)
    assert np.allclose(one.boxes_px, boxes[kept], atol=1e-3)
    assert one.category_ids.tolist() == (category[kept] + 1).tolist()
    assert (np.diff(one.scores) <= 0).all()


def test_an_object_alone_knows_about_where_its_corners_are() -> None:
    one = answers((27, 2.0, 0, 3))
    for k, said in enumerate(([-1, -2, np.log(0.5), 3], [1, -2, 0, 3], [1, 2, 0, -3], [-1, 2, 0, 3])):
        own_corner(one, 27, k)[:] = said
    seen = found(one)
    x, y = POINTS[27]
    assert seen.keypoints_px[0].tolist() == [[x - 8, y - 16], [x + 8, y - 16], [x + 8, y + 16], [x - 8, y + 16]]
    assert seen.keypoint_sigma_px[0].tolist() == pytest.approx([4 * 2**0.5, *3 * [8 * 2**0.5]])
    assert seen.keypoint_scores[0].tolist() == pytest.approx([0.9526, 0.9526, 0.0474, 0.9526], abs=1e-4)


def test_the_points_nearby_know_exactly() -> None:
    """Of the corners seen the likeliest within reach counts, by certainty; the others are left alone."""
    one = answers((27, 2.0, 0, 3))
    own_corner(one, 27, 0)[3] = 3.0
    for k in (1, 2, 3):
        own_corner(one, 27, k)[:2] = 3.0
    one.corners[:4, 27] = [4, 0.25, 0.0, np.log(0.05)]  # 2 px to the right
    one.corners[:4, 28] = [4, -0.625, 0.0, np.log(0.1)]  # 3 px to the right: the same corner
    one.corners[:4, 19] = [4, -0.1, 0.125, np.log(0.3)]  # 7 px above: another one
    one.corners[:4, 26] = [-4, 0.9, 0.0, np.log(0.01)]  # not sure
    one.corners[:4, 31] = [4, 0.0, 0.0, np.log(0.01)]  # out of reach
    seen = found(one)
    weights = np.array([1 / 0.05**2, 1 / 0.1**2])
    expected = POINTS[27] + (weights @ [2.0, 3.0] / weights.sum(), 0.0)
    assert seen.keypoints_px[0, 0] == pytest.approx(expected, abs=1e-4)
    sigma_px = weights @ [0.05, 0.1] / weights.sum() * 8 * 2**0.5
    assert seen.keypoint_sigma_px[0, 0] == pytest.approx(sigma_px, rel=1e-4)
    assert seen.keypoints_px[0, 1] == pytest.approx(POINTS[27] + 24)
