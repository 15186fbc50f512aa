import math

import numpy as np
import pytest
from floor_pictures import look

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.edge_fit import EdgeFit, EdgeFitParams, fit_edges, offset_jacobian
from adc_bench.stack.edge_search import EdgeSearchParams, expect_edges, find_edges
from adc_bench.stack.paint_edges import paint_edges
from adc_bench.stack.pose_filter import PITCH, ROLL, SIZE, YAW, Estimate, StartSpread, start_estimate, widened
from adc_bench.world.course import Course

COURSE, SEARCH, PARAMS = Course(), EdgeSearchParams(), EdgeFitParams()
EDGES = paint_edges(COURSE)


def estimate_at(pose: Pose2, position_m: float = 0.02, yaw_rad: float = 0.01) -> Estimate:
    return widened(start_estimate(pose, StartSpread()), position_m, yaw_rad)


def fit_at(eye: BirdsEye, estimate: Estimate, picture: np.ndarray, news: float = 1.0) -> EdgeFit:
    tilted = BirdsEye(mount=eye.mount, tilt_rad=estimate.tilt_rad)
    pose = estimate.belief.pose
    expected = expect_edges(tilted, EDGES.seen_from(pose), SEARCH)
    jacobian = offset_jacobian(expected, tilted, pose.yaw_rad)
    spread = np.sqrt(np.einsum("ni,ij,nj->n", jacobian, estimate.covariance, jacobian))
    found, offsets = find_edges(picture, expected, spread, SEARCH)
    return fit_edges(estimate, expected.of(found), offsets, jacobian[found], news, PARAMS)


def test_the_offsets_jacobian_is_the_derivative(birds_eye: BirdsEye) -> None:
    """The truth differs from the estimate by a little of each unknown in turn: edges move by the Jacobian's column.

    The oracle looks through the tilted camera and lays out what it sees by the estimate, with no part of the filter.
    """
    pose = COURSE.lap.pose(9.0)
    eye = BirdsEye(mount=birds_eye.mount, tilt_rad=(0.004, -0.003))
    expected = expect_edges(eye, EDGES.seen_from(pose), SEARCH)
    jacobian = offset_jacobian(expected, eye, pose.yaw_rad)
    points_world, normals_robot = pose.transform(expected.edges_robot.points), expected.edges_robot.normals
    step = 1e-5
    for column in (0, 1, YAW, PITCH, ROLL):
        moved = np.zeros(SIZE)
        moved[column] = step
        truth = Pose2(x_m=pose.x_m + moved[0], y_m=pose.y_m + moved[1], yaw_rad=pose.yaw_rad + moved[YAW])
        true_eye = BirdsEye(mount=eye.mount, tilt_rad=(0.004 + moved[PITCH], -0.003 + moved[ROLL]))
        pixels = true_eye.to_pixels(truth.inverse().transform(points_world))
        offsets = np.sum((eye.to_floor(pixels) - expected.edges_robot.points) * normals_robot, axis=1)
        wanted = jacobian[:, column]
        assert (np.abs(offsets / step - wanted) < 2e-3 * (1 + np.abs(wanted))).all()
    assert not jacobian[:, 3:5].any()


@pytest.mark.parametrize("s_m", [-0.65, 9.0, 17.0, 22.0, 30.0])  # on the last but one the yaw is half a turn
def test_an_error_of_centimetres_is_mended(birds_eye: BirdsEye, s_m: float) -> None:
    truth = COURSE.lap.pose(s_m)
    picture = look(truth, mount=birds_eye.mount)
    fit = fit_at(birds_eye, estimate_at(truth @ Pose2(x_m=0.02, y_m=-0.015, yaw_rad=0.01)), picture)
    error = truth.inverse() @ fit.estimate.belief.pose
    # The oracle's floor is drawn in cells of 5 mm.
    assert math.hypot(error.x_m, error.y_m) < 0.006
    assert abs(error.yaw_rad) < math.radians(0.15)
    assert fit.agreeing > 60


def test_the_cameras_tilt_is_found(birds_eye: BirdsEye) -> None:
    """From a crosswalk, where edges run every way; over all places pose and tilt together explain the picture."""
    truth, tilt = COURSE.lap.pose(-0.65), (math.radians(0.3), math.radians(-0.25))
    picture = look(truth, mount=birds_eye.mount, pitch_error_rad=tilt[0], roll_error_rad=tilt[1])
    estimate = start_estimate(truth, StartSpread())
    for _ in range(6):
        estimate = fit_at(birds_eye, estimate, picture).estimate
    np.testing.assert_allclose(estimate.tilt_rad, tilt, atol=math.radians(0.1))


def test_things_on_the_road_do_not_move_the_pose(birds_eye: BirdsEye) -> None:
    """A pale box and a dark shadow cover a third of the lane ahead."""
    truth = COURSE.lap.pose(9.0)
    clear = look(truth, mount=birds_eye.mount)
    covered = clear.copy()
    covered[90:150, 150:230] = 170
    covered[150:200, 60:150] = covered[150:200, 60:150] // 3
    estimate = estimate_at(truth @ Pose2(x_m=0.01, y_m=0.01, yaw_rad=-0.005))
    one, other = (fit_at(birds_eye, estimate, picture).estimate.mean[:3] for picture in (clear, covered))
    assert np.hypot(*(one - other)[:2]) < 0.004
    assert abs(one[YAW] - other[YAW]) < math.radians(0.15)


def test_a_picture_that_is_no_news_tells_less(birds_eye: BirdsEye) -> None:
    truth = COURSE.lap.pose(3.0)
    picture, estimate = look(truth, mount=birds_eye.mount), estimate_at(truth)
    fresh, stale = (fit_at(birds_eye, estimate, picture, news).estimate.covariance for news in (1.0, 0.1))
    assert np.linalg.eigvalsh(stale - fresh).min() > -1e-12
    assert stale[1, 1] > 2 * fresh[1, 1]


def test_a_picture_of_elsewhere_does_not_agree(birds_eye: BirdsEye) -> None:
    believed, truth = COURSE.lap.pose(9.0), COURSE.lap.pose(30.0)
    fit = fit_at(birds_eye, estimate_at(believed), look(truth, mount=birds_eye.mount))
    right = fit_at(birds_eye, estimate_at(truth), look(truth, mount=birds_eye.mount))
    assert fit.agreeing < 0.4 * right.agreeing
