import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from adc_bench.geometry import Pose2
from adc_bench.stack.pose_filter import (
    GYRO_BIAS,
    SCALE,
    SIZE,
    YAW,
    Estimate,
    MotionNoise,
    Residuals,
    StartSpread,
    Travel,
    correct,
    move,
    move_jacobian,
    predict,
    squared_distance,
    start_estimate,
    widened,
)

NOISE = MotionNoise()
START = Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)
seeds = st.integers(0, 2**32 - 1)


def a_travel(rng: np.random.Generator, steps: int = 7) -> Travel:
    return Travel(
        duration_s=rng.uniform(0.002, 0.01, steps),
        forward_m=rng.uniform(-0.02, 0.02, steps),
        turn_rad=rng.uniform(-0.02, 0.02, steps),
        slip_m=0.0,
    )


def a_mean(rng: np.random.Generator) -> np.ndarray:
    return np.array([*rng.uniform(-6, 6, 2), rng.uniform(-3, 3), *rng.normal(0, 0.01, 4)])


def a_covariance(rng: np.random.Generator, size: int = SIZE) -> np.ndarray:
    root = rng.normal(0, 0.01, (size, size))
    return root @ root.T + 1e-6 * np.eye(size)


@given(seeds)
def test_the_motion_jacobian_is_the_derivative(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mean, way, step = a_mean(rng), a_travel(rng), 1e-6
    columns = [(move(mean + d, way) - move(mean - d, way)) / (2 * step) for d in step * np.eye(SIZE)]
    np.testing.assert_allclose(move_jacobian(mean, way), np.stack(columns, axis=1), atol=1e-8)


def test_steps_at_a_steady_turn_lie_on_the_arc() -> None:
    steps, turn, length = 200, 1.2, 2.0
    way = Travel(
        duration_s=np.full(steps, 0.01),
        forward_m=np.full(steps, length / steps),
        turn_rad=np.full(steps, turn / steps),
        slip_m=0.0,
    )
    radius = length / turn
    end = move(np.zeros(SIZE), way)
    np.testing.assert_allclose(end[:3], [radius * math.sin(turn), radius * (1 - math.cos(turn)), turn], atol=1e-5)


def test_bias_and_scale_are_taken_out() -> None:
    way = Travel(duration_s=np.full(10, 0.01), forward_m=np.full(10, 0.01), turn_rad=np.full(10, 0.002), slip_m=0.0)
    mean = np.zeros(SIZE)
    mean[GYRO_BIAS], mean[SCALE] = 0.2, 0.01
    np.testing.assert_allclose(move(mean, way)[:3], [0.101, 0.0, 0.0], atol=1e-12)


@given(seeds)
def test_a_travel_may_be_cut_anywhere(seed: int) -> None:
    rng = np.random.default_rng(seed)
    estimate, whole = Estimate(mean=a_mean(rng), covariance=a_covariance(rng)), a_travel(rng)
    first, last = (
        Travel(duration_s=whole.duration_s[k], forward_m=whole.forward_m[k], turn_rad=whole.turn_rad[k], slip_m=0.0)
        for k in (slice(0, 3), slice(3, None))
    )
    once, twice = predict(estimate, whole, NOISE), predict(predict(estimate, first, NOISE), last, NOISE)
    np.testing.assert_allclose(once.mean, twice.mean, atol=1e-12)
    np.testing.assert_allclose(once.covariance, twice.covariance, atol=1e-7)


@given(seeds, st.integers(1, 30))
def test_a_correction_is_the_textbooks(seed: int, rows: int) -> None:
    rng = np.random.default_rng(seed)
    estimate = Estimate(mean=a_mean(rng), covariance=a_covariance(rng))
    H, r, variances = rng.normal(size=(rows, SIZE)), rng.normal(0, 0.01, rows), rng.uniform(1e-5, 1e-3, rows)
    after = correct(estimate, Residuals(values=r, jacobian=H, variances=variances))
    S = H @ estimate.covariance @ H.T + np.diag(variances)
    K = estimate.covariance @ H.T @ np.linalg.inv(S)
    wanted = estimate.mean + K @ r
    np.testing.assert_allclose(np.delete(after.mean, YAW), np.delete(wanted, YAW), atol=1e-8)
    np.testing.assert_allclose(after.covariance, (np.eye(SIZE) - K @ H) @ estimate.covariance, atol=1e-9)


@given(seeds, st.integers(1, SIZE))
def test_the_distance_of_few_rows_is_the_innovations(seed: int, rows: int) -> None:
    rng = np.random.default_rng(seed)
    estimate = Estimate(mean=a_mean(rng), covariance=a_covariance(rng))
    H, r, variances = rng.normal(size=(rows, SIZE)), rng.normal(0, 0.1, rows), rng.uniform(1e-3, 1e-2, rows)
    distance, freedoms = squared_distance(estimate, Residuals(values=r, jacobian=H, variances=variances))
    S = H @ estimate.covariance @ H.T + np.diag(variances)
    assert freedoms == rows
    assert distance == pytest.approx(r @ np.linalg.solve(S, r), rel=1e-4)


def test_consistent_on_a_linear_gaussian_world() -> None:
    """Errors drawn as the filter believes them: NEES and NIS are within their 95 % bounds over 300 runs."""
    rng, runs, nees, nis = np.random.default_rng(3), 300, [], []
    still = Travel(duration_s=np.full(5, 0.01), forward_m=np.zeros(5), turn_rad=np.zeros(5), slip_m=0.0)
    for _ in range(runs):
        estimate = start_estimate(START, StartSpread())
        truth = rng.multivariate_normal(estimate.mean, estimate.covariance)
        for _ in range(4):
            estimate = predict(estimate, still, NOISE)
            truth = move(truth, still)
            truth[YAW] += NOISE.yaw_rad_sqrts * math.sqrt(0.05) * rng.standard_normal()
            truth[GYRO_BIAS] += NOISE.bias_radps_sqrts * math.sqrt(0.05) * rng.standard_normal()
            H, variances = rng.normal(size=(20, SIZE)), np.full(20, 1e-4)
            seen = H @ (truth - estimate.mean) + rng.normal(0, 1e-2, 20)
            residuals = Residuals(values=seen, jacobian=H, variances=variances)
            distance, freedoms = squared_distance(estimate, residuals)
            assert freedoms == SIZE
            nis.append(distance)
            estimate = correct(estimate, residuals)
        error = truth - estimate.mean
        nees.append(error @ np.linalg.solve(estimate.covariance, error))
    for values in (nees, nis):
        low, high = chi2.ppf([0.025, 0.975], SIZE * len(values)) / len(values)
        assert low < np.mean(values) < high


def test_slip_is_doubt_along_the_way() -> None:
    steady = {"duration_s": np.full(5, 0.01), "forward_m": np.full(5, 0.01), "turn_rad": np.zeros(5)}
    before = start_estimate(START, StartSpread())
    with_slip = predict(before, Travel(**steady, slip_m=0.03), NOISE).covariance
    without = predict(before, Travel(**steady, slip_m=0.0), NOISE).covariance
    assert with_slip[0, 0] - without[0, 0] == pytest.approx(0.03**2)
    assert with_slip[1, 1] == pytest.approx(without[1, 1])


def test_widening_leaves_the_mean_and_what_is_no_pose() -> None:
    before = start_estimate(START, StartSpread())
    after = widened(before, 0.05, 0.03)
    np.testing.assert_array_equal(after.mean, before.mean)
    gained = np.diag(after.covariance - before.covariance)
    np.testing.assert_allclose(gained, [0.05**2, 0.05**2, 0.03**2, 0, 0, 0, 0], atol=1e-15)
