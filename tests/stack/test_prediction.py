import math

import numpy as np
import pytest
from driven_robot import PERIOD_S, START, simulation

from adc_bench.geometry import Pose2
from adc_bench.stack.prediction import arc_step, at_rest, send, when_acting
from adc_bench.world.robot import Motion, RobotParams

ROBOT = RobotParams()


@pytest.mark.parametrize("latency_s", [0.0, 0.05, 0.12])
def test_the_simulated_robot_is_where_it_was_foreseen(latency_s: float) -> None:
    world, state = simulation(seed=3), at_rest(PERIOD_S, latency_s)
    late = 1 + math.ceil(latency_s / PERIOD_S)
    assert len(state.commands) == late
    rng, foreseen, queue = np.random.default_rng(1), [], [Motion()] * late
    for step in range(120):
        pose = world.state().pose_world_robot
        foreseen.append(when_acting(state, ROBOT, pose, PERIOD_S))
        if step >= late:
            there, motion = foreseen[step - late]
            assert (pose.x_m, pose.y_m) == pytest.approx((there.x_m, there.y_m), abs=0.004)
            assert pose.yaw_rad == pytest.approx(there.yaw_rad, abs=0.01)
            assert world.state().v_mps == pytest.approx(motion.v_mps, abs=0.05)
        command = Motion(v_mps=1.5 + 0.5 * float(rng.uniform(-1, 1)), omega_radps=float(rng.uniform(-1.0, 1.0)))
        state = send(state, ROBOT, command, PERIOD_S)
        queue.append(command)
        acting = queue.pop(0)
        world.advance(acting.v_mps, acting.omega_radps)


def test_a_robot_at_rest_stays() -> None:
    pose, motion = when_acting(at_rest(PERIOD_S, 0.0), ROBOT, START, PERIOD_S)
    assert (pose, motion) == (START, Motion())


def test_commands_beyond_the_limits_lead_where_the_limits_do() -> None:
    state = at_rest(PERIOD_S, 0.0)
    for _ in range(40):
        state = send(state, ROBOT, Motion(v_mps=9.0), PERIOD_S)
    assert state.motion.v_mps == ROBOT.speed_max_mps


def test_arc_steps_add_up() -> None:
    whole, half = arc_step(1.0, 0.8), arc_step(0.5, 0.4)
    twice = half @ half
    assert (twice.x_m, twice.y_m, twice.yaw_rad) == pytest.approx((whole.x_m, whole.y_m, whole.yaw_rad))
    assert arc_step(1.0, 0.0) == Pose2(x_m=1.0, y_m=0.0, yaw_rad=0.0)
