"""The regulator against a plain Riccati recursion, and the errors that it brings to nothing."""

import math

import numpy as np
import pytest

from adc_bench.geometry import Path, Pose2
from adc_bench.geometry.path import line
from adc_bench.stack.prediction import arc_step
from adc_bench.stack.reference_line import rounded
from adc_bench.stack.timetable import SpeedLimits, Timetable, fastest
from adc_bench.stack.tracker import SPEEDS_MPS, Tracker, TrackerParams, error_model, gains, regulator
from adc_bench.world.drive import ramp
from adc_bench.world.robot import Motion, RobotParams

PERIOD_S = 0.05
PARAMS, ROBOT = TrackerParams(), RobotParams()
STRAIGHT = rounded(Path(start=Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), pieces=(line(40.0),)), 0.0, 40.0)
AHEAD = Timetable(line=STRAIGHT, speed_mps=np.full(len(STRAIGHT.s_m), 2.0))
TRACKER = Tracker(robot=ROBOT, period_s=PERIOD_S, timetable=AHEAD)


@pytest.mark.parametrize("speed_mps", [0.1, 1.0, 2.2])
def test_the_regulator_is_what_a_long_plan_comes_to(speed_mps: float) -> None:
    A, B = error_model(speed_mps, PERIOD_S)
    Q, r = np.diag([PARAMS.offset_m**-2, PARAMS.heading_rad**-2]), PARAMS.correction_radps**-2
    cost = Q
    for _ in range(4000):
        gain = (B.T @ cost @ A) / (r + B.T @ cost @ B)
        cost = Q + A.T @ cost @ (A - B @ gain)
    np.testing.assert_allclose(regulator(speed_mps, PERIOD_S, PARAMS), gain[0], rtol=1e-6)
    assert np.abs(np.linalg.eigvals(A - B @ gain)).max() < 1.0


def test_the_error_model_is_the_robots_motion() -> None:
    offset_m, heading_rad, turn_radps, speed_mps = 0.01, 0.005, 0.02, 1.7
    pose = Pose2(x_m=0.0, y_m=offset_m, yaw_rad=heading_rad) @ arc_step(speed_mps * PERIOD_S, turn_radps * PERIOD_S)
    A, B = error_model(speed_mps, PERIOD_S)
    np.testing.assert_allclose(A @ [offset_m, heading_rad] + B[:, 0] * turn_radps, [pose.y_m, pose.yaw_rad], atol=1e-6)


def test_gains_change_smoothly_with_speed() -> None:
    table = np.array([gains(float(v), PERIOD_S, PARAMS) for v in np.linspace(0.1, 3.0, 200)])
    assert (table > 0).all()
    assert np.abs(np.diff(table, axis=0)).max() < 0.2
    assert gains(0.0, PERIOD_S, PARAMS) == gains(SPEEDS_MPS[0], PERIOD_S, PARAMS)


@pytest.mark.parametrize(("aside_m", "askew_rad"), [(0.10, 0.0), (-0.10, 0.0), (0.0, 0.06), (0.05, -0.04)])
def test_errors_fall_as_the_closed_loop_says(aside_m: float, askew_rad: float) -> None:
    pose = Pose2(x_m=1.0, y_m=aside_m, yaw_rad=askew_rad)
    motion, s_m = Motion(v_mps=2.0), 1.0
    A, B = error_model(2.0, PERIOD_S)
    gain = regulator(2.0, PERIOD_S, PARAMS)[None]
    expected = np.array([aside_m, askew_rad])
    for _ in range(40):
        s_m, command = TRACKER.track(s_m, pose, motion)
        for _ in range(50):
            motion = ramp(ROBOT, motion, command, PERIOD_S / 50)
            pose = pose @ arc_step(motion.v_mps * PERIOD_S / 50, motion.omega_radps * PERIOD_S / 50)
        expected = (A - B @ gain) @ expected
        assert (pose.y_m, pose.yaw_rad) == pytest.approx(tuple(expected), abs=0.012)
    assert (pose.y_m, pose.yaw_rad) == pytest.approx((0.0, 0.0), abs=0.004)


@pytest.mark.parametrize("wanted_radps", [-0.15, -0.05, 0.0, 0.1, 0.28])
def test_the_mean_turn_over_a_step_is_the_wanted_one(wanted_radps: float) -> None:
    heading_gain = gains(1.0, PERIOD_S, PARAMS)[1]
    still = Motion(v_mps=1.0, omega_radps=0.1)
    steady = Timetable(line=STRAIGHT, speed_mps=np.full(len(STRAIGHT.s_m), 1.0))
    tracker = Tracker(robot=ROBOT, period_s=PERIOD_S, timetable=steady)
    _, command = tracker.track(1.0, Pose2(x_m=1.0, y_m=0.0, yaw_rad=-wanted_radps / heading_gain), still)
    motion, turned = still, 0.0
    for _ in range(1000):
        motion = ramp(ROBOT, motion, command, PERIOD_S / 1000)
        turned += motion.omega_radps * PERIOD_S / 1000
    assert turned / PERIOD_S == pytest.approx(wanted_radps, abs=1e-3)


def test_an_offset_beyond_belief_counts_as_the_bound() -> None:
    far, farther = (Pose2(x_m=2.0, y_m=y_m, yaw_rad=0.0) for y_m in (PARAMS.offset_max_m, 3.0))
    assert TRACKER.track(2.0, far, Motion(v_mps=2.0))[1] == TRACKER.track(2.0, farther, Motion(v_mps=2.0))[1]


def test_it_sets_out_and_stops_by_the_timetable() -> None:
    short = rounded(Path(start=Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), pieces=(line(3.0),)), 0.0, 3.0)
    tracker = Tracker(robot=ROBOT, period_s=PERIOD_S, timetable=fastest(short, SpeedLimits.of(ROBOT)))
    pose, motion, s_m = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), Motion(), 0.0
    speeds = []
    for _ in range(70):
        s_m, command = tracker.track(s_m, pose, motion)
        motion = ramp(ROBOT, motion, command, PERIOD_S)
        pose = pose @ arc_step(motion.v_mps * PERIOD_S, motion.omega_radps * PERIOD_S)
        speeds.append(motion.v_mps)
    assert speeds[:4] == pytest.approx([0.1, 0.2, 0.3, 0.4], abs=0.03)
    assert max(speeds) == pytest.approx(math.sqrt(2.0 * 3.0), abs=0.3)
    assert pose.x_m == pytest.approx(3.0, abs=0.05)
    assert speeds[-1] == 0.0
