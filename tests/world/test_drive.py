import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from adc_bench.world.drive import limit, ramp, wheel_speeds_radps
from adc_bench.world.robot import Motion, RobotParams

ROBOT = RobotParams()
motions = st.builds(
    Motion, v_mps=st.floats(-1e3, 1e3, allow_nan=False), omega_radps=st.floats(-1e3, 1e3, allow_nan=False)
)


def rims_mps(motion: Motion) -> tuple[float, float]:
    left, right = wheel_speeds_radps(ROBOT, motion)
    return left * ROBOT.wheel_radius_m, right * ROBOT.wheel_radius_m


@given(motions)
def test_no_command_breaks_a_limit(wanted: Motion) -> None:
    allowed = limit(ROBOT, wanted)
    assert abs(allowed.v_mps) <= ROBOT.speed_max_mps
    assert abs(allowed.omega_radps) <= ROBOT.turn_rate_max_radps
    assert max(map(abs, rims_mps(allowed))) <= ROBOT.rim_speed_max_mps * (1 + 1e-12)


@given(st.floats(-0.8, 0.8), st.floats(-1.5, 1.5))
def test_a_motion_within_the_limits_passes_unchanged(v_mps: float, omega_radps: float) -> None:
    wanted = Motion(v_mps=v_mps, omega_radps=omega_radps)
    assert limit(ROBOT, wanted) == wanted


def test_a_rim_too_fast_slows_the_robot_on_the_same_curve() -> None:
    allowed = limit(ROBOT, Motion(v_mps=2.2, omega_radps=4.0))
    assert max(rims_mps(allowed)) == pytest.approx(2.45)
    assert allowed.omega_radps / allowed.v_mps == pytest.approx(4.0 / 2.2)


@given(motions, motions)
def test_the_set_point_nears_its_target_within_the_acceleration(now: Motion, target: Motion) -> None:
    after = ramp(ROBOT, now, target, 0.005)
    reach_mps = ROBOT.acceleration_max_mps2 * 0.005
    turning_mps = (after.omega_radps - now.omega_radps) * ROBOT.wheel_separation_m / 2
    assert abs(after.v_mps - now.v_mps) <= reach_mps + 1e-9
    assert abs(turning_mps) <= reach_mps + 1e-9
    assert abs(target.v_mps - after.v_mps) <= abs(target.v_mps - now.v_mps)
    assert abs(target.omega_radps - after.omega_radps) <= abs(target.omega_radps - now.omega_radps)


def test_steering_does_not_wait_for_speed() -> None:
    motion = Motion()
    for _ in range(20):
        motion = ramp(ROBOT, motion, Motion(v_mps=2.0, omega_radps=1.0), 0.005)
    assert motion.v_mps == pytest.approx(0.2)
    assert motion.omega_radps == 1.0


def test_wheel_speeds_are_those_of_the_kinematics() -> None:
    left, right = wheel_speeds_radps(ROBOT, Motion(v_mps=0.5, omega_radps=math.pi))
    assert (left + right) / 2 * 0.0975 == pytest.approx(0.5)
    assert (right - left) * 0.0975 / 0.33 == pytest.approx(math.pi)
