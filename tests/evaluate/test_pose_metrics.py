import math

import numpy as np
import pytest
from scipy.stats import chi2

from adc_bench.evaluate.metrics import COVERED_NEES, dead_reckoning, localization, nees
from adc_bench.geometry import Pose2
from adc_bench.world.robot import RobotParams

ROBOT = RobotParams()


def test_estimates_drawn_from_their_own_covariance_are_consistent() -> None:
    rng = np.random.default_rng(0)
    truth = rng.uniform(-3, 3, size=(4000, 3))
    root = np.array([[0.1, 0.0, 0.0], [0.05, 0.2, 0.0], [0.01, -0.02, 0.03]])
    estimate = truth + rng.standard_normal((4000, 3)) @ root.T
    covariance = np.broadcast_to(root @ root.T, (4000, 3, 3))
    found = localization(truth, estimate, covariance, truth[:, :2])
    assert found.nees_mean == pytest.approx(3.0, abs=0.15)
    assert found.coverage == pytest.approx(0.95, abs=0.012)
    assert found.dead_reckoning_rmse_m == found.dead_reckoning_max_m == 0.0


def test_nees_against_the_inverse() -> None:
    rng = np.random.default_rng(1)
    truth, estimate = rng.standard_normal((2, 50, 3))
    roots = rng.standard_normal((50, 3, 3))
    covariance = roots @ roots.transpose(0, 2, 1) + 0.1 * np.eye(3)
    values = nees(truth, estimate, covariance)
    for k in range(50):
        error = estimate[k] - truth[k]
        error[2] = math.atan2(math.sin(error[2]), math.cos(error[2]))
        assert values[k] == pytest.approx(error @ np.linalg.inv(covariance[k]) @ error)


def test_a_covariance_that_is_none_covers_nothing() -> None:
    truth = np.zeros((2, 3))
    covariance = np.array([np.eye(3), np.diag([1.0, 1.0, 0.0])])
    found = localization(truth, truth, covariance, truth[:, :2])
    assert (found.nees_mean, found.coverage) == (0.0, 0.5)


def test_the_covered_region_is_the_chi_square_one() -> None:
    assert chi2.cdf(COVERED_NEES, df=3) == pytest.approx(0.95)


def test_position_and_heading_errors_by_hand() -> None:
    truth = np.array([[0.0, 0.0, 3.1], [1.0, 1.0, 0.0]])
    estimate = np.array([[0.3, 0.4, -3.1], [1.0, 1.0, 0.0]])
    found = localization(truth, estimate, None, truth[:, :2])
    assert found.position_max_m == pytest.approx(0.5)
    assert found.position_rmse_m == pytest.approx(0.5 / math.sqrt(2))
    assert found.heading_rmse_rad == pytest.approx((2 * math.pi - 6.2) / math.sqrt(2))
    assert found.nees_mean is None and found.coverage is None


@pytest.mark.parametrize(("v_mps", "omega_radps"), [(1.0, 0.0), (0.8, 0.4), (0.5, -0.9)])
def test_dead_reckoning_follows_the_exact_arc(v_mps: float, omega_radps: float) -> None:
    """Ticks of a perfect robot on a circle, against the circle."""
    start = Pose2(x_m=1.0, y_m=-2.0, yaw_rad=0.5)
    time_s = np.arange(0.0, 10.0, 0.02)
    per_m = ROBOT.encoder_ticks_per_turn / (2 * math.pi * ROBOT.wheel_radius_m)
    half_m = ROBOT.wheel_separation_m / 2
    left = np.floor((v_mps - omega_radps * half_m) * time_s * per_m)
    right = np.floor((v_mps + omega_radps * half_m) * time_s * per_m)
    times_s = np.array([0.0, 2.51, 9.9])
    found = dead_reckoning(start, ROBOT, time_s, left, right, times_s)
    for (x_m, y_m), at_s in zip(found, times_s, strict=True):
        turn = omega_radps * at_s
        chord_m = v_mps * at_s * float(np.sinc(turn / 2 / np.pi))
        ahead = Pose2(x_m=chord_m * math.cos(turn / 2), y_m=chord_m * math.sin(turn / 2), yaw_rad=turn)
        exact = start @ ahead
        assert math.hypot(x_m - exact.x_m, y_m - exact.y_m) < 0.02
