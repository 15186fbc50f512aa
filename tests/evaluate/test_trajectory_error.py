"""ATE, RPE and the verdict on NEES: against definitions written out, and minima found by search."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import chi2

from adc_bench.evaluate.metrics import RPE_STEPS, localization, position_errors_m, rms
from adc_bench.evaluate.trajectory_error import aligned, nees_verdict, relative_errors
from adc_bench.geometry import Pose2


def wandering(seed: int, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Return a path (n, 3) and an estimate that strays from it."""
    rng = np.random.default_rng(seed)
    truth = np.cumsum(rng.normal(0.0, (0.2, 0.2, 0.3), (n, 3)), axis=0)
    return truth, truth + np.cumsum(rng.normal(0.0, (0.02, 0.02, 0.03), (n, 3)), axis=0)


def pose(row: np.ndarray) -> Pose2:
    return Pose2(x_m=float(row[0]), y_m=float(row[1]), yaw_rad=float(row[2]))


@pytest.mark.parametrize("seed", range(3))
def test_alignment_is_the_best_that_a_search_finds(seed: int) -> None:
    truth, estimate = wandering(seed)

    def left_over(motion: np.ndarray) -> float:
        moved = pose(motion).transform(estimate[:, :2])
        return float(np.sum((moved - truth[:, :2]) ** 2))

    least = minimize(left_over, np.zeros(3), method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-12}).fun
    assert np.sum(position_errors_m(truth, aligned(truth, estimate)) ** 2) == pytest.approx(least, rel=1e-6)


def test_alignment_takes_a_rigid_motion_back() -> None:
    truth, _ = wandering(5)
    moved = np.array(
        [(p.x_m, p.y_m, p.yaw_rad) for p in (Pose2(x_m=3.0, y_m=-1.0, yaw_rad=2.5) @ pose(r) for r in truth)]
    )
    back = aligned(truth, moved)
    assert back[:, :2] == pytest.approx(truth[:, :2])
    assert np.exp(1j * back[:, 2]) == pytest.approx(np.exp(1j * truth[:, 2]))


@pytest.mark.parametrize("steps", [1, 7])
def test_relative_errors_against_poses_one_by_one(steps: int) -> None:
    truth, estimate = wandering(1)
    distance_m, angle_rad = relative_errors(truth, estimate, steps)
    assert len(distance_m) == len(truth) - steps
    for i in range(len(truth) - steps):
        true_motion = pose(truth[i]).inverse() @ pose(truth[i + steps])
        motion = pose(estimate[i]).inverse() @ pose(estimate[i + steps])
        error = true_motion.inverse() @ motion
        assert distance_m[i] == pytest.approx(math.hypot(error.x_m, error.y_m))
        assert angle_rad[i] == pytest.approx(abs(math.remainder(error.yaw_rad, 2 * math.pi)))


def test_a_shifted_map_has_neither_ate_nor_rpe() -> None:
    truth, _ = wandering(2)
    shifted = truth + np.array([0.3, 0.4, 0.0])
    found = localization(truth, shifted, None, truth[:, :2])
    assert found.position_rmse_m == pytest.approx(0.5)
    assert (found.ate_rmse_m, found.rpe_rmse_m, found.rpe_rmse_rad) == pytest.approx((0.0, 0.0, 0.0))


def test_the_run_reports_a_second_of_drift() -> None:
    truth, estimate = wandering(3)
    found = localization(truth, estimate, None, truth[:, :2])
    distance_m, angle_rad = relative_errors(truth, estimate, RPE_STEPS)
    assert (found.rpe_rmse_m, found.rpe_rmse_rad) == (rms(distance_m), rms(angle_rad))
    short = localization(truth[:RPE_STEPS], estimate[:RPE_STEPS], None, truth[:RPE_STEPS, :2])
    assert short.rpe_rmse_m is None and short.rpe_rmse_rad is None


@pytest.mark.parametrize(
    ("means", "verdict"),
    [([3.1, 2.7, 3.6, 2.2], "consistent"), ([3.0, 20.0, 2.0, 9.0], "overconfident"), ([0.3] * 4, "overcautious")],
)
def test_the_verdict_on_nees(means: list[float], verdict: str) -> None:
    found = nees_verdict(means)
    assert (found.verdict, found.n) == (verdict, 4)
    assert chi2.cdf(np.array([found.low, found.high]) * 4, 12) == pytest.approx((0.025, 0.975))


def test_an_honest_filter_is_seldom_found_wrong() -> None:
    """Runs whose error never changes are the worst case: 5 % of them are found wrong; changing ones less often."""
    rng = np.random.default_rng(6)
    fixed = chi2.rvs(3, size=(2000, 5), random_state=rng)
    assert np.mean([nees_verdict(run).verdict != "consistent" for run in fixed]) == pytest.approx(0.05, abs=0.015)
    changing = chi2.rvs(3, size=(2000, 5, 30), random_state=rng).mean(axis=2)
    assert all(nees_verdict(run).verdict == "consistent" for run in changing)
