import math

import numpy as np
import pytest
from floor_pictures import look

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.edge_search import EdgeSearchParams, ExpectedEdges, expect_edges, find_edges
from adc_bench.stack.paint_edges import paint_edges
from adc_bench.world.course import Course

COURSE, PARAMS = Course(), EdgeSearchParams()
EDGES = paint_edges(COURSE)
POSES = [COURSE.lap.pose(s) for s in (-0.65, 3.0, 9.0, 17.0, 22.0, 31.0)]


def expected_at(eye: BirdsEye, pose: Pose2) -> ExpectedEdges:
    return expect_edges(eye, EDGES.seen_from(pose), PARAMS)


def shift_m(birds_eye: BirdsEye, pose: Pose2, moved: Pose2, **how: float) -> np.ndarray:
    """Return the offsets of edges expected at a pose in a picture from one that is moved against it."""
    expected = expected_at(birds_eye, pose)
    spread = np.full(len(expected.scale_px_pm), 0.02)
    _, offsets = find_edges(look(pose @ moved, mount=birds_eye.mount, **how), expected, spread, PARAMS)
    return offsets


def test_expected_edges_lie_in_the_picture_where_the_camera_has_them(birds_eye: BirdsEye) -> None:
    for pose in POSES:
        expected = expected_at(birds_eye, pose)
        assert len(expected.scale_px_pm) > 50
        np.testing.assert_allclose(expected.pixels_px, birds_eye.to_pixels(expected.edges_robot.points), atol=1e-12)
        assert (expected.pixels_px > 3).all() and (expected.pixels_px < (317, 237)).all()


def test_across_is_square_to_the_edge_and_the_scale_is_the_projections(birds_eye: BirdsEye) -> None:
    expected = expected_at(birds_eye, POSES[2])
    points, normals = expected.edges_robot.points, expected.edges_robot.normals
    along = np.stack([-normals[:, 1], normals[:, 0]], axis=1)
    step = 1e-5
    tangent = (birds_eye.to_pixels(points + step * along) - birds_eye.to_pixels(points - step * along)) / (2 * step)
    outward = (birds_eye.to_pixels(points + step * normals) - birds_eye.to_pixels(points - step * normals)) / (2 * step)
    cosine = np.sum(tangent * expected.across_px, axis=1) / np.hypot(*tangent.T)
    assert np.abs(cosine).max() < 0.01
    np.testing.assert_allclose(np.sum(outward * expected.across_px, axis=1), expected.scale_px_pm, rtol=0.03)


def test_edges_are_found_where_they_are(birds_eye: BirdsEye) -> None:
    """All but the bloom: a picture shows every mark a fraction of a pixel too wide."""
    for pose in POSES:
        expected = expected_at(birds_eye, pose)
        spread = np.full(len(expected.scale_px_pm), 0.02)
        found, offsets = find_edges(look(pose, mount=birds_eye.mount), expected, spread, PARAMS)
        assert found.mean() > 0.85
        off_px = offsets * expected.scale_px_pm[found]
        assert np.median(np.abs(off_px)) < 0.5
        assert np.median(off_px) > 0.0


def test_a_robot_that_stands_aside_finds_the_lines_aside(birds_eye: BirdsEye) -> None:
    pose = COURSE.lap.pose(3.0)
    expected = expected_at(birds_eye, pose)
    normals = expected.edges_robot.normals[:, 1]
    near = expected.of((normals > 0.99) & (expected.scale_px_pm > 120))
    middles = []
    for aside_m in (-0.02, 0.015):
        picture = look(pose @ Pose2(x_m=0.0, y_m=aside_m, yaw_rad=0.0), mount=birds_eye.mount)
        _, offsets = find_edges(picture, near, np.full(len(near.scale_px_pm), 0.02), PARAMS)
        middles.append(np.median(offsets))
    assert middles[0] - middles[1] == pytest.approx(0.035, abs=0.001)


@pytest.mark.parametrize(
    "how", [{"paint_level": 40.0}, {"floor_level": 0.0, "paint_level": 0.0, "noise": 0.7}], ids=["bare", "black"]
)
def test_a_picture_without_paint_shows_next_to_nothing(birds_eye: BirdsEye, how: dict[str, float]) -> None:
    for pose in POSES:
        assert len(shift_m(birds_eye, pose, Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), **how)) < 0.1 * len(
            expected_at(birds_eye, pose).scale_px_pm
        )


def test_half_the_light_leaves_the_edges_where_they_are(birds_eye: BirdsEye) -> None:
    still = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    for pose in POSES:
        bright = shift_m(birds_eye, pose, still)
        dark = shift_m(birds_eye, pose, still, shade=0.7, vignetting=0.3)
        assert len(dark) > 0.85 * len(bright)
        assert abs(np.median(dark) - np.median(bright)) < 0.002


def test_nothing_is_expected_where_there_is_no_paint(birds_eye: BirdsEye) -> None:
    away = Pose2(x_m=20.0, y_m=0.0, yaw_rad=math.pi / 2)
    expected = expected_at(birds_eye, away)
    found, offsets = find_edges(look(POSES[0]), expected, np.empty(0), PARAMS)
    assert len(found) == len(offsets) == 0
