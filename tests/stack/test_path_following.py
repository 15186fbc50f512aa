import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adc_bench.geometry import Pose2
from adc_bench.stack.path_following import Follower, FollowParams, follow, progress, wrap_to
from adc_bench.stack.prediction import arc_step
from adc_bench.world.course import Course

LAP = Course().lap
PERIOD_S = 0.05


def drive(speed_mps: float, start: Pose2, start_s_m: float, seconds: float) -> tuple[np.ndarray, float]:
    """Return the offsets from the lane's middle and the progress, with commands that act one step late."""
    pose, state, acting = start, Follower(s_m=start_s_m), 0.0
    offsets = []
    for _ in range(round(seconds / PERIOD_S)):
        ahead = pose @ arc_step(speed_mps * PERIOD_S, acting * PERIOD_S)
        state, omega_radps = follow(state, ahead, LAP, speed_mps, PERIOD_S, FollowParams())
        pose = pose @ arc_step(speed_mps * PERIOD_S, acting * PERIOD_S)
        acting = omega_radps
        _, offset = LAP.project([(pose.x_m, pose.y_m)], around_s_m=state.s_m % LAP.length_m)
        offsets.append(float(offset[0]))
    return np.array(offsets), state.s_m


@pytest.mark.parametrize("speed_mps", [0.5, 1.0, 1.5])
def test_the_whole_lap_is_followed_within_centimetres(speed_mps: float) -> None:
    seconds = (LAP.length_m + 1.0) / speed_mps
    offsets, s_m = drive(speed_mps, LAP.pose(0.0), 0.0, seconds)
    assert np.abs(offsets).max() < 0.03 * max(speed_mps, 1.0)
    assert s_m == pytest.approx(LAP.length_m + 1.0, abs=0.3)


@pytest.mark.parametrize("aside_m", [-0.15, 0.15])
def test_it_comes_back_to_the_lane(aside_m: float) -> None:
    offsets, _ = drive(1.0, LAP.pose(1.0) @ Pose2(x_m=0.0, y_m=aside_m, yaw_rad=0.0), 1.0, 4.0)
    assert abs(offsets[-1]) < 0.01
    assert np.abs(offsets).max() < 0.16


def test_progress_keeps_its_branch_where_the_road_crosses_itself() -> None:
    crossing = LAP.pose(22.5)
    assert progress(22.4, crossing, LAP) == pytest.approx(22.5)
    assert progress(22.4 + LAP.length_m, crossing, LAP) == pytest.approx(22.5 + LAP.length_m)


def test_progress_grows_past_the_start_line() -> None:
    s_m = -0.65
    for x_m in np.arange(-0.6, 0.6, 0.1):
        s_m = progress(s_m, Pose2(x_m=float(x_m), y_m=-2.6125, yaw_rad=0.0), LAP)
        assert s_m == pytest.approx(x_m)
    assert progress(LAP.length_m - 0.1, LAP.pose(0.1), LAP) == pytest.approx(LAP.length_m + 0.1)


def test_wrap_to_is_the_nearest_way_round() -> None:
    assert wrap_to(39.0, 40.0) == pytest.approx(-1.0)
    assert wrap_to(-39.0, 40.0) == pytest.approx(1.0)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.8, 0.8)), min_size=2, max_size=12))
def test_on_a_straight_it_is_the_thesis_pid(places: list[tuple[float, float]]) -> None:
    params, state, speed_mps = FollowParams(), Follower(s_m=1.0), 1.0
    integral, last = 0.0, None
    for k, (y_m, yaw_rad) in enumerate(places):
        x_m = 1.0 + 0.05 * k
        pose = Pose2(x_m=x_m, y_m=LAP.start.y_m + y_m, yaw_rad=yaw_rad)
        state, omega_radps = follow(state, pose, LAP, speed_mps, PERIOD_S, params)
        error = math.atan2(-y_m, params.look_ahead_m) - yaw_rad
        integral += error * PERIOD_S
        rate = 0.0 if last is None else (error - last) / PERIOD_S
        assert omega_radps == pytest.approx(1.6 * error + 0.01 * integral + 0.4 * rate, abs=1e-9)
        last = error
