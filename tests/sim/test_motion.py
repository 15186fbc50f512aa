import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from adc_bench.geometry import Pose2
from adc_bench.sim import DYNAMICS, Simulation
from adc_bench.world.robot import RobotParams
from adc_bench.world.scenario import Scenario

Draw = Callable[[int], Scenario]


@pytest.mark.parametrize(("x_m", "y_m", "yaw_rad"), [(-0.65, -2.6125, 0.0), (5.35, 2.6125, math.pi), (-8.0, 0.0, -1.2)])
def test_starts_still_where_it_is_put(drawn: Draw, x_m: float, y_m: float, yaw_rad: float) -> None:
    state = Simulation(drawn(3), Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw_rad)).state()
    pose = state.pose_world_robot
    assert math.hypot(pose.x_m - x_m, pose.y_m - y_m) < 1e-3
    assert abs(math.remainder(pose.yaw_rad - yaw_rad, 2 * math.pi)) < 1e-3
    assert abs(state.v_mps) < 1e-3
    assert abs(state.omega_radps) < 1e-3


def test_stays_still_at_rest(drawn: Draw, start: Pose2) -> None:
    sim = Simulation(drawn(4), start)
    before = sim.state().pose_world_robot
    heights = []
    for _ in range(200):
        sim.advance(0.0, 0.0)
        heights.append(sim.pose3_world_robot().translation_m[2])
        assert abs(sim.state().v_mps) < 1e-3
    after = before.inverse() @ sim.state().pose_world_robot
    assert math.hypot(after.x_m, after.y_m) < 1e-3
    assert abs(after.yaw_rad) < 1e-3
    assert np.ptp(heights) < 1e-5
    encoders = sim.read_sensors().encoders
    assert np.ptp(encoders.left_ticks) <= 1
    assert np.ptp(encoders.right_ticks) <= 1


def test_straight_ahead_is_straight_and_as_far_as_commanded(nominal: Scenario, start: Pose2) -> None:
    sim = Simulation(nominal, start)
    for _ in range(100):
        sim.advance(1.0, 0.0)
    moved = start.inverse() @ sim.state().pose_world_robot
    assert moved.x_m == pytest.approx(5.0 - 0.25, rel=0.005)  # 0.5 s of ramp lose 0.25 m
    assert abs(moved.y_m) < 0.01
    assert sim.state().v_mps == pytest.approx(1.0, rel=0.005)


@pytest.mark.parametrize("v_mps", [0.5, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("radius_m", [2.6125, -1.8375])
def test_circles_have_the_commanded_radius(nominal: Scenario, v_mps: float, radius_m: float) -> None:
    sim = Simulation(nominal, Pose2(x_m=5.35, y_m=-math.copysign(2.6, radius_m), yaw_rad=0.0))
    places = []
    for _ in range(240):
        sim.advance(v_mps, v_mps / radius_m)
        pose = sim.state().pose_world_robot
        places.append((pose.x_m, pose.y_m))
    x, y = np.array(places[80:]).T
    # An independent circle through the places: x^2 + y^2 = a x + b y + c by least squares.
    (a, b, c), *_ = np.linalg.lstsq(np.stack([x, y, np.ones_like(x)], axis=1), x**2 + y**2, rcond=None)
    assert math.sqrt(c + a**2 / 4 + b**2 / 4) == pytest.approx(abs(radius_m), rel=0.01)
    state = sim.state()
    assert state.v_mps == pytest.approx(v_mps, rel=0.01)
    assert state.omega_radps == pytest.approx(v_mps / radius_m, rel=0.015)


def test_true_wheels_turn_the_command_into_another_motion(drawn: Draw, start: Pose2) -> None:
    arena = drawn(5)
    truth, robot = arena.robot_truth, arena.robot
    sim = Simulation(arena, start)
    for _ in range(60):
        sim.advance(0.8, 0.6)
    left, right = (0.8 - 0.6 * 0.165) / robot.wheel_radius_m, (0.8 + 0.6 * 0.165) / robot.wheel_radius_m
    rim_left, rim_right = left * truth.wheel_radius_left_m, right * truth.wheel_radius_right_m
    assert sim.state().v_mps == pytest.approx((rim_left + rim_right) / 2, rel=0.003)
    assert sim.state().omega_radps == pytest.approx((rim_right - rim_left) / truth.wheel_separation_m, rel=0.01)


@pytest.mark.parametrize("v_mps", [0.5, 1.0, 1.5, 2.0])
def test_s_curves_slip_little(nominal: Scenario, v_mps: float) -> None:
    sim = Simulation(nominal, Pose2(x_m=-9.0, y_m=0.0, yaw_rad=-0.5))
    reckoned = sim.state().pose_world_robot
    for k in range(round(16 / v_mps / 0.05)):  # 16 m
        sim.advance(v_mps, v_mps / 1.8375 * math.sin(0.05 * k * v_mps))
    encoders = sim.read_sensors().encoders
    ticks = np.diff(np.stack([encoders.left_ticks, encoders.right_ticks], axis=1), axis=0)
    for left_m, right_m in ticks * (2 * math.pi * 0.0975 / 500):
        turn, chord = (right_m - left_m) / 0.33, (left_m + right_m) / 2
        reckoned = reckoned @ Pose2(x_m=chord * math.cos(turn / 2), y_m=chord * math.sin(turn / 2), yaw_rad=turn)
    slipped = sim.state().pose_world_robot.inverse() @ reckoned
    assert sim.take_contacts() == []
    assert math.hypot(slipped.x_m, slipped.y_m) < 0.005 * 16
    assert abs(slipped.yaw_rad) < 0.01


def test_speed_changes_no_faster_than_allowed_and_brakes_to_a_stop(nominal: Scenario) -> None:
    sim = Simulation(nominal, Pose2(x_m=-10.0, y_m=-2.6125, yaw_rad=0.0))
    speeds, pitches = [sim.state().v_mps], []
    for k in range(100):
        sim.advance(9.0 if k < 50 else 0.0, 0.0)
        speeds.append(sim.state().v_mps)
        pitches.append(math.asin(-sim.pose3_world_robot().rotation[2, 0]))
    assert max(speeds) == pytest.approx(2.2, rel=0.005)
    assert np.abs(np.diff(speeds)).max() < 2.0 * 0.05 * 1.05
    assert abs(speeds[-1]) < 2e-3
    braking_s = 0.05 * sum(1 for v in speeds[50:] if v > 0.01)
    assert braking_s == pytest.approx(1.1, abs=0.1)
    assert np.abs(pitches).max() < math.radians(0.2)


def test_turns_on_the_spot_within_the_turn_rate(nominal: Scenario, start: Pose2) -> None:
    sim = Simulation(nominal, start)
    for _ in range(60):
        sim.advance(0.0, 99.0)
    moved = start.inverse() @ sim.state().pose_world_robot
    assert sim.state().omega_radps == pytest.approx(math.radians(300), rel=0.01)
    assert math.hypot(moved.x_m, moved.y_m) < 0.05


def test_backwards_is_forwards_mirrored(nominal: Scenario, start: Pose2) -> None:
    sim = Simulation(nominal, start)
    for _ in range(40):
        sim.advance(-0.5, 0.0)
    assert sim.state().v_mps == pytest.approx(-0.5, rel=0.01)


def test_twice_the_physics_rate_changes_little(nominal: Scenario, start: Pose2) -> None:
    ends = []
    for rate_hz in (200, 400):
        sim = Simulation(nominal, start, dynamics=msgspec.structs.replace(DYNAMICS, physics_rate_hz=rate_hz))
        for k in range(100):
            sim.advance(1.0, 0.5 * math.sin(0.05 * k))
        ends.append(sim.state().pose_world_robot)
    apart = ends[0].inverse() @ ends[1]
    assert math.hypot(apart.x_m, apart.y_m) < 0.03


def test_a_small_wheeled_robot_drives_as_well(nominal: Scenario, start: Pose2) -> None:
    conde = RobotParams(name="conde", wheel_radius_m=0.032, mass_kg=10.6)
    truth = msgspec.structs.replace(nominal.robot_truth, wheel_radius_left_m=0.032, wheel_radius_right_m=0.032)
    sim = Simulation(msgspec.structs.replace(nominal, robot=conde, robot_truth=truth), start)
    for _ in range(60):
        sim.advance(1.0, 0.5)
    assert sim.state().v_mps == pytest.approx(1.0, rel=0.01)
    assert sim.state().omega_radps == pytest.approx(0.5, rel=0.02)


def test_time_is_counted_in_steps(nominal: Scenario, start: Pose2) -> None:
    sim = Simulation(nominal, start)
    times = []
    for k in range(30):
        assert sim.step_index == k
        times.append(sim.time_s)
        sim.advance(0.0, 0.0)
    assert times == [k / 20 for k in range(30)]


def test_refuses_a_command_that_is_no_number(nominal: Scenario, start: Pose2) -> None:
    with pytest.raises(AssertionError, match="the caller checks commands"):
        Simulation(nominal, start).advance(math.nan, 0.0)


def test_refuses_a_period_that_is_no_whole_number_of_physics_steps(nominal: Scenario, start: Pose2) -> None:
    with pytest.raises(AssertionError, match="must divide the physics rate"):
        Simulation(nominal, start, 0.033)
