"""Straight ways and turns on a robot that does as told, at once: ends, directions, and that no piece lasts for ever."""

import math

import numpy as np
import pytest

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.manoeuvre import Manoeuvre, ManoeuvreParams, Straight, Turn, follow_manoeuvre, next_speed
from adc_bench.stack.prediction import arc_step
from adc_bench.world.robot import Motion

PERIOD_S = 0.05
PARAMS = ManoeuvreParams()
ORIGIN = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)


def driven(manoeuvre: Manoeuvre, pose: Pose2, seed: int | None = None) -> tuple[Pose2, int]:
    """Return where a manoeuvre ends, and after how many steps; with a seed poses are told with 1 cm and 0.5 deg."""
    rng, motion = np.random.default_rng(seed), Motion()
    for step in range(1000):
        x_m, y_m, yaw_rad = rng.standard_normal(3) * (0.01, 0.01, math.radians(0.5)) * (seed is not None)
        told = Pose2(x_m=pose.x_m + x_m, y_m=pose.y_m + y_m, yaw_rad=pose.yaw_rad + yaw_rad)
        manoeuvre, command = follow_manoeuvre(manoeuvre, told, motion, PERIOD_S, PARAMS)
        if not manoeuvre and command == Motion() == motion:
            return pose, step
        mean = [(a + b) / 2 for a, b in ((motion.v_mps, command.v_mps), (motion.omega_radps, command.omega_radps))]
        pose, motion = pose @ arc_step(mean[0] * PERIOD_S, mean[1] * PERIOD_S), command
    raise AssertionError("the manoeuvre never ended")


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("aside_m", [0.0, 0.03])
def test_a_straight_way_ends_at_its_goal(reverse: bool, aside_m: float) -> None:
    goal = Pose2(x_m=-1.5 if reverse else 1.5, y_m=0.0, yaw_rad=0.0)
    end, steps = driven((Straight(goal=goal, reverse=reverse),), Pose2(x_m=0.0, y_m=aside_m, yaw_rad=0.05))
    assert math.hypot(end.x_m - goal.x_m, end.y_m) < 0.01 and abs(end.yaw_rad) < 0.02
    assert steps * PERIOD_S < 1.5 / PARAMS.speed_mps + 1.5


@pytest.mark.parametrize("yaw_rad", [math.pi / 2, -math.pi / 2, 3.0, -3.0, 0.02])
@pytest.mark.parametrize("from_rad", [0.0, 3.1])
def test_a_turn_ends_at_its_heading_the_shorter_way_round(yaw_rad: float, from_rad: float) -> None:
    start = Pose2(x_m=1.0, y_m=2.0, yaw_rad=from_rad)
    end, steps = driven((Turn(yaw_rad=yaw_rad),), start)
    assert (end.x_m, end.y_m) == (1.0, 2.0)
    assert abs(wrap_rad(end.yaw_rad - yaw_rad)) < math.radians(0.5)
    assert steps * PERIOD_S < abs(wrap_rad(yaw_rad - from_rad)) / PARAMS.turn_radps + 1.5


def test_pieces_follow_one_another() -> None:
    corner, end = Pose2(x_m=1.0, y_m=0.0, yaw_rad=0.0), Pose2(x_m=1.0, y_m=-0.8, yaw_rad=math.pi / 2)
    pose, _ = driven((Straight(goal=corner), Turn(yaw_rad=math.pi / 2), Straight(goal=end, reverse=True)), ORIGIN)
    assert np.allclose((pose.x_m, pose.y_m, pose.yaw_rad), (1.0, -0.8, math.pi / 2), atol=0.01)


@pytest.mark.parametrize("seed", range(5))
def test_noisy_poses_neither_hold_it_up_nor_lead_it_away(seed: int) -> None:
    corner, end = Pose2(x_m=1.0, y_m=0.0, yaw_rad=0.0), Pose2(x_m=1.0, y_m=-0.8, yaw_rad=math.pi / 2)
    manoeuvre = (Straight(goal=corner), Turn(yaw_rad=math.pi / 2), Straight(goal=end, reverse=True), Turn(yaw_rad=0.0))
    pose, steps = driven(manoeuvre, ORIGIN, seed)
    assert np.allclose((pose.x_m, pose.y_m), (1.0, -0.8), atol=0.04) and abs(pose.yaw_rad) < math.radians(3)
    assert steps * PERIOD_S < 10.0


@pytest.mark.parametrize("now", [0.0, 0.4, 0.8])
@pytest.mark.parametrize("left", [0.3, 0.5, 2.0])
def test_the_next_speed_leaves_just_enough_to_brake_in(now: float, left: float) -> None:
    speed = next_speed(left, now, math.inf, 1.5, PERIOD_S)
    assert (now + speed) * PERIOD_S / 2 + speed**2 / 3.0 == pytest.approx(left)
    assert next_speed(left, now, 0.2, 1.5, PERIOD_S) == 0.2
    assert next_speed(0.0, now, math.inf, 1.5, PERIOD_S) == 0.0


def test_of_nothing_nothing_is_left_but_to_stand() -> None:
    assert follow_manoeuvre((), ORIGIN, Motion(v_mps=0.5), PERIOD_S, PARAMS) == ((), Motion())
