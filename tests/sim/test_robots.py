"""Each robot of the benchmark at its limits, and what friction and torque allow beyond them."""

import math

import msgspec
import numpy as np
import pytest

from adc_bench.api import EncoderSamples
from adc_bench.geometry import Pose2
from adc_bench.sim import DYNAMICS, Simulation
from adc_bench.sim.surfaces import GRAVITY_MPS2
from adc_bench.world.robot import ROBOTS, RobotName, RobotParams, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.streams import stream

ALL: tuple[RobotName, ...] = ("pioneer", "pioneer-stock", "conde")
STRAIGHT = Pose2(x_m=-10.0, y_m=-2.6125, yaw_rad=0.0)
CHASSIS = DYNAMICS.chassis


def with_robot(nominal: Scenario, robot: RobotParams) -> Scenario:
    """The robot exactly as its data sheet says."""
    truth = msgspec.structs.replace(
        nominal.robot_truth,
        wheel_radius_left_m=robot.wheel_radius_m,
        wheel_radius_right_m=robot.wheel_radius_m,
        wheel_separation_m=robot.wheel_separation_m,
    )
    return msgspec.structs.replace(nominal, robot=robot, robot_truth=truth)


def throttle(sim: Simulation, steps: int, v_mps: float, omega_radps: float = 0.0) -> tuple[list[float], list[float]]:
    """Return speed and turn rate at the end of each control step."""
    speeds, turns = [sim.state().v_mps], [sim.state().omega_radps]
    for _ in range(steps):
        sim.advance(v_mps, omega_radps)
        speeds.append(sim.state().v_mps)
        turns.append(sim.state().omega_radps)
    return speeds, turns


def rolled_m(robot: RobotParams, encoders: EncoderSamples) -> float:
    """Return how far the wheels' rims have turned."""
    ticks = (encoders.left_ticks[-1] + encoders.right_ticks[-1]) / 2
    return float(ticks) * 2 * math.pi * robot.wheel_radius_m / robot.encoder_ticks_per_turn


def load_on_wheels() -> float:
    """The share of the weight that the two wheels carry at rest: the castor has the rest."""
    return 1 - CHASSIS.centre_of_mass_x_m / CHASSIS.castor_x_m


@pytest.mark.parametrize("name", ALL)
def test_full_speed_and_acceleration_are_the_robots_own(nominal: Scenario, name: RobotName) -> None:
    robot = ROBOTS[name]
    sim = Simulation(with_robot(nominal, robot), STRAIGHT)
    speeds, _ = throttle(sim, 50, 99.0)
    assert speeds[-1] == pytest.approx(robot.speed_max_mps, rel=0.005)
    assert max(speeds) < robot.speed_max_mps * 1.01
    assert np.diff(speeds).max() < robot.acceleration_max_mps2 * 0.05 * 1.05
    assert np.diff(speeds)[2:8].mean() == pytest.approx(robot.acceleration_max_mps2 * 0.05, rel=0.05)
    moved = STRAIGHT.inverse() @ sim.state().pose_world_robot
    assert abs(moved.y_m) < 0.02
    assert rolled_m(robot, sim.read_sensors().encoders) == pytest.approx(moved.x_m, rel=0.01), "without slip"


@pytest.mark.parametrize("name", ALL)
def test_turn_rate_and_rim_speed_are_the_robots_own(nominal: Scenario, name: RobotName) -> None:
    robot = ROBOTS[name]
    arena = with_robot(nominal, robot)
    _, turns = throttle(Simulation(arena, STRAIGHT), 50, 0.0, 99.0)
    assert turns[-1] == pytest.approx(robot.turn_rate_max_radps, rel=0.01)
    assert max(turns) < robot.turn_rate_max_radps * 1.02
    # A wide turn at the rim's limit: fast, and round enough for the outer rim to be the bound.
    sim = Simulation(arena, Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0))
    v_mps, omega_radps = robot.speed_max_mps, 2 * (robot.rim_speed_max_mps - robot.speed_max_mps + 0.3)
    speeds, turns = throttle(sim, 60, v_mps, omega_radps)
    rims = np.array(speeds) + np.abs(turns) * robot.wheel_separation_m / 2
    assert rims.max() < robot.rim_speed_max_mps * 1.02


@pytest.mark.parametrize("name", ALL)
def test_stands_still_drives_and_turns_as_told(nominal: Scenario, name: RobotName) -> None:
    sim = Simulation(with_robot(nominal, ROBOTS[name]), STRAIGHT)
    heights = []
    for _ in range(40):
        sim.advance(0.0, 0.0)
        heights.append(sim.pose3_world_robot().translation_m[2])
    still = STRAIGHT.inverse() @ sim.state().pose_world_robot
    assert math.hypot(still.x_m, still.y_m) < 1e-3 and np.ptp(heights) < 1e-5
    throttle(sim, 60, 1.0, 0.5)
    assert sim.state().v_mps == pytest.approx(1.0, rel=0.01)
    assert sim.state().omega_radps == pytest.approx(0.5, rel=0.02)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("friction", [0.05, 0.1])
def test_on_ice_the_wheels_spin_and_friction_drives(nominal: Scenario, name: RobotName, friction: float) -> None:
    robot = msgspec.structs.replace(ROBOTS[name], friction=friction)
    sim = Simulation(with_robot(nominal, robot), STRAIGHT)
    speeds, _ = throttle(sim, 20, 99.0)
    grip_mps2 = friction * GRAVITY_MPS2 * load_on_wheels()
    gained_mps2 = (speeds[18] - speeds[4]) / (14 * 0.05)
    assert gained_mps2 == pytest.approx(grip_mps2, rel=0.15)
    moved = STRAIGHT.inverse() @ sim.state().pose_world_robot
    spun_m = rolled_m(robot, sim.read_sensors().encoders)
    assert spun_m > 1.5 * moved.x_m, "the encoders count the wheels' turning"


def test_a_wider_limit_than_the_friction_slips(nominal: Scenario) -> None:
    """At the public limits the tyres hold; told to pull away three times as hard, they do not."""
    robot = msgspec.structs.replace(ROBOTS["pioneer"], acceleration_max_mps2=9.0)
    speeds, _ = throttle(Simulation(with_robot(nominal, robot), STRAIGHT), 5, 99.0)
    assert max(np.diff(speeds)) / 0.05 < robot.friction * GRAVITY_MPS2 * 1.02
    assert speeds[-1] < 0.85 * min(robot.speed_max_mps, 5 * 0.05 * 9.0)


@pytest.mark.parametrize("name", ALL)
def test_weak_motors_accelerate_by_their_torque(nominal: Scenario, name: RobotName) -> None:
    """Newton's law with the rotors' and wheels' own inertia, seen at the rim."""
    robot = ROBOTS[name]
    weak = msgspec.structs.replace(CHASSIS, torque_margin=0.3)
    dynamics = msgspec.structs.replace(DYNAMICS, chassis=weak)
    speeds, _ = throttle(Simulation(with_robot(nominal, robot), STRAIGHT, dynamics=dynamics), 20, 99.0)
    shares = 1 + 2 * weak.rotor_mass_share + 2 * weak.wheel_mass_share / 2
    expected_mps2 = 2 * weak.torque_margin * robot.acceleration_max_mps2 / shares
    assert (speeds[15] - speeds[5]) / 0.5 == pytest.approx(expected_mps2, rel=0.03)


@pytest.mark.parametrize("name", ALL)
def test_a_wall_is_pushed_no_harder_than_torque_and_grip_allow(nominal: Scenario, name: RobotName) -> None:
    robot = ROBOTS[name]
    sim = Simulation(with_robot(nominal, robot), Pose2(x_m=10.6, y_m=0.0, yaw_rad=0.0))
    throttle(sim, 40, 99.0)
    sim.take_contacts()
    throttle(sim, 20, 99.0)
    pushed_n = sum(contact.impulse_ns for contact in sim.take_contacts())  # over one second
    motors_n = 2 * CHASSIS.torque_margin * robot.mass_kg * robot.acceleration_max_mps2
    grip_n = robot.friction * robot.mass_kg * GRAVITY_MPS2
    assert 0.25 * motors_n < pushed_n < min(motors_n, grip_n) * 1.01
    assert abs(sim.state().v_mps) < 0.01


@pytest.mark.parametrize("name", ALL)
def test_drawn_robots_differ_about_their_own_figures(name: RobotName) -> None:
    robot = ROBOTS[name]
    truths = [draw_robot_truth(robot, stream(seed, "robot")) for seed in range(300)]
    left = np.array([truth.wheel_radius_left_m for truth in truths])
    right = np.array([truth.wheel_radius_right_m for truth in truths])
    assert np.std((left + right) / 2) == pytest.approx(0.003 * robot.wheel_radius_m, rel=0.15)
    assert np.std(right - left) == pytest.approx(0.0005 * robot.wheel_radius_m, rel=0.15)
    assert np.std([t.wheel_separation_m for t in truths]) == pytest.approx(0.005 * robot.wheel_separation_m, rel=0.15)
