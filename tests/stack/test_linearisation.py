"""The thesis' trajectory tracking against its equations, its error dynamics, and a robot brought to its place."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.linearisation import LinearisationParams, follow_moving
from adc_bench.stack.prediction import arc_step
from adc_bench.world.robot import Motion

PARAMS = LinearisationParams()
poses = st.builds(Pose2, x_m=st.floats(-5, 5), y_m=st.floats(-5, 5), yaw_rad=st.floats(-3, 3))


@given(poses, poses, st.floats(-2.0, 2.0), st.floats(-3.0, 3.0))
def test_it_is_the_thesis_law(pose: Pose2, wanted: Pose2, v_d: float, omega_d: float) -> None:
    found = follow_moving(pose, wanted, Motion(v_mps=v_d, omega_radps=omega_d), PARAMS)
    zeta, g = PARAMS.zeta, PARAMS.g_pm2
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    dx, dy = wanted.x_m - pose.x_m, wanted.y_m - pose.y_m
    e1, e2, e3 = c * dx + s * dy, -s * dx + c * dy, wrap_rad(wanted.yaw_rad - pose.yaw_rad)
    k1 = k3 = 2 * zeta * math.sqrt(omega_d**2 + g * v_d**2)
    k2 = g * abs(v_d)
    assert found.v_mps == pytest.approx(v_d * math.cos(e3) + k1 * e1, abs=1e-9)
    assert found.omega_radps == pytest.approx(omega_d + k2 * np.sign(v_d) * e2 + k3 * e3, abs=1e-9)


@pytest.mark.parametrize(("v_d", "omega_d"), [(1.0, 0.0), (2.0, 0.8), (0.5, -1.2)])
def test_small_errors_obey_the_polynomial_that_the_gains_were_made_for(v_d: float, omega_d: float) -> None:
    feed = Motion(v_mps=v_d, omega_radps=omega_d)

    def rate(errors: np.ndarray) -> np.ndarray:
        e1, e2, e3 = errors
        pose = (Pose2(x_m=float(e1), y_m=float(e2), yaw_rad=float(e3))).inverse()
        motion = follow_moving(pose, Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), feed, PARAMS)
        v, omega = motion.v_mps, motion.omega_radps
        return np.array([omega * e2 + v_d * math.cos(e3) - v, -omega * e1 + v_d * math.sin(e3), omega_d - omega])

    small = 1e-6
    jacobian = np.column_stack([(rate(small * unit) - rate(-small * unit)) / (2 * small) for unit in np.eye(3)])
    speed = math.sqrt(omega_d**2 + PARAMS.g_pm2 * v_d**2)
    wanted = np.polymul([1.0, 2 * PARAMS.zeta * speed], [1.0, 2 * PARAMS.zeta * speed, speed**2])
    np.testing.assert_allclose(np.poly(jacobian), wanted, rtol=1e-5)


def test_errors_fall_at_the_rate_of_the_slow_pair() -> None:
    feed, period_s = Motion(v_mps=1.0, omega_radps=0.4), 0.002
    wanted = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    pose = wanted @ Pose2(x_m=-0.2, y_m=0.15, yaw_rad=-0.3)
    sizes = []
    for _ in range(round(4.0 / period_s)):
        motion = follow_moving(pose, wanted, feed, PARAMS)
        pose = pose @ arc_step(motion.v_mps * period_s, motion.omega_radps * period_s)
        wanted = wanted @ arc_step(feed.v_mps * period_s, feed.omega_radps * period_s)
        sizes.append(math.hypot(wanted.x_m - pose.x_m, wanted.y_m - pose.y_m))
    decay_radps = PARAMS.zeta * math.sqrt(0.4**2 + PARAMS.g_pm2)
    assert sizes[-1] < 3 * sizes[0] * math.exp(-decay_radps * 4.0) + 1e-6


def test_a_robot_in_its_place_is_left_alone() -> None:
    pose, feed = Pose2(x_m=1.0, y_m=-2.0, yaw_rad=0.5), Motion(v_mps=1.3, omega_radps=-0.4)
    found = follow_moving(pose, pose, feed, PARAMS)
    assert (found.v_mps, found.omega_radps) == pytest.approx((1.3, -0.4))
    assert follow_moving(pose, Pose2(x_m=1.2, y_m=-2.0, yaw_rad=0.5), Motion(), PARAMS) == Motion()
