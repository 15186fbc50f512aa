import math

import numpy as np
import pytest
from floor_pictures import look
from hypothesis import given
from hypothesis import strategies as st

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.circle import CircleParams, circle_through, first_centre, radius_fits, see_circle
from adc_bench.stack.ekf import Belief
from adc_bench.stack.lane_lines import LaneLines, find_lane_lines
from adc_bench.stack.lane_map import LaneMap
from adc_bench.stack.paint import find_paint
from adc_bench.stack.robust_fit import Fit
from adc_bench.world.course import Course

COURSE = Course()
angles = st.floats(0, 2 * math.pi)


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(0.5, 5), angles)
def test_three_points_give_their_circle(x_m: float, y_m: float, radius_m: float, start_rad: float) -> None:
    centre = np.array([x_m, y_m])
    points = [centre + radius_m * np.array([math.cos(start_rad + a), math.sin(start_rad + a)]) for a in (0, 0.7, 1.9)]
    found = circle_through(*points)
    assert found is not None
    np.testing.assert_allclose(found[0], centre, atol=1e-6)
    assert found[1] == pytest.approx(radius_m, abs=1e-6)


def test_points_on_a_straight_line_give_none() -> None:
    assert circle_through((0, 0), (1, 1), (2, 2)) is None


def test_the_radius_test_is_stricter_over_a_longer_chord() -> None:
    params = CircleParams()
    assert radius_fits(2.9, 3.0, 1.5, params)
    assert not radius_fits(1.45, 3.0, 1.5, params)
    assert not radius_fits(4.4, 3.0, 1.5, params)
    assert not radius_fits(1.45, 3.0, 0.8, params)
    assert radius_fits(4.4, 3.0, 0.7, params)


def arc_points(radius_m: float, turn: float) -> np.ndarray:
    a = np.linspace(0.2, 0.8, 15)
    return np.column_stack([radius_m * np.sin(a), turn * radius_m * (1 - np.cos(a))])


def test_a_centre_on_the_other_side_or_another_radius_is_refused() -> None:
    params = CircleParams()
    assert first_centre(arc_points(3.0, 1), 3.0, 1, params) is not None
    assert first_centre(arc_points(3.0, 1), 3.0, -1, params) is None
    assert first_centre(arc_points(1.45, 1), 3.0, 1, params) is None
    assert first_centre(arc_points(3.0, 1)[:4], 3.0, 1, params) is None


def circle_at(birds_eye: BirdsEye, s_m: float, pose: Pose2, tilt: tuple[float, float], seed: int) -> Fit | None:
    picture = look(pose, mount=birds_eye.mount, pitch_error_rad=tilt[0], roll_error_rad=tilt[1], seed=seed)
    lane_map = LaneMap(course=COURSE, lap=COURSE.lap)
    lines = find_lane_lines(LaneLines(), find_paint(birds_eye, picture), lane_map.half_lane_m)
    belief = Belief(mean=np.array([pose.x_m, pose.y_m, pose.yaw_rad]), covariance=np.zeros((3, 3)))
    curves = [stretch for stretch in lane_map.stretches(lines, belief, s_m) if stretch.curvature_pm != 0]
    return see_circle(curves[0].by_radius(), curves[0].curvature_pm, birds_eye) if curves else None


@pytest.mark.parametrize(("s_m", "centre"), [(9.0, (5.35, 0.0)), (17.8, (0.90, 0.0)), (30.0, (-5.35, 0.0))])
def test_centres_of_loops_and_s_roads_from_pixels(birds_eye: BirdsEye, s_m: float, centre: tuple[float, float]) -> None:
    """The lines' radii differ: 3.00 and 2.225 in the first loop, 1.45 and 2.225 beyond."""
    pose = COURSE.lap.pose(s_m)
    curve = circle_at(birds_eye, s_m, pose, (0.0, 0.0), seed=1)
    assert curve is not None
    truth = pose.inverse().transform([centre])[0]
    error = curve.parameters - truth
    assert np.hypot(*error) < 0.05
    assert error @ np.linalg.solve(curve.covariance, error) < 16


def test_the_covariance_is_honest_about_an_unknown_tilt(birds_eye: BirdsEye) -> None:
    rng = np.random.default_rng(5)
    distances = []
    for seed in range(24):
        s_m = float(rng.uniform(6.5, 14.5))
        pose = COURSE.lap.pose(s_m) @ Pose2(
            x_m=0.0, y_m=0.03 * rng.standard_normal(), yaw_rad=0.03 * rng.standard_normal()
        )
        pitch, roll = np.radians(0.3) * rng.standard_normal(2)
        seen = circle_at(birds_eye, s_m, pose, (pitch, roll), seed)
        assert seen is not None
        error = seen.parameters - pose.inverse().transform([(5.35, 0.0)])[0]
        assert np.hypot(*error) < 0.15
        distances.append(error @ np.linalg.solve(seen.covariance, error))
    assert 0.3 < np.mean(distances) < 3.0  # two degrees of freedom; a little too careful is as wanted
