import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.ekf import (
    CHI2_99,
    Belief,
    SeenLine,
    WheelModel,
    compare_line,
    compare_point,
    correct,
    move,
    move_jacobians,
    nearest,
    predict,
    see_line,
    see_point,
    start_belief,
)

MODEL = WheelModel(radius_m=0.0975, separation_m=0.33)
coordinates, angles, wheels = st.floats(-8, 8), st.floats(-3, 3), st.floats(-15, 15)


def derivative(function: Callable[[np.ndarray], np.ndarray], at: np.ndarray) -> np.ndarray:
    step = 1e-6
    return np.stack([(function(at + d) - function(at - d)) / (2 * step) for d in step * np.eye(len(at))], axis=1)


@given(coordinates, coordinates, angles, wheels, wheels)
def test_the_motion_jacobians_are_the_derivatives(x: float, y: float, yaw: float, left: float, right: float) -> None:
    mean, speeds, dt_s = np.array([x, y, yaw]), np.array([left, right]), 0.02
    G, V = move_jacobians(mean, speeds, dt_s, MODEL)
    np.testing.assert_allclose(G, derivative(lambda m: move(m, speeds, dt_s, MODEL), mean), atol=1e-6)
    np.testing.assert_allclose(V, derivative(lambda u: move(mean, u, dt_s, MODEL), speeds), atol=1e-6)


@given(coordinates, coordinates, angles, coordinates, coordinates)
def test_the_landmark_jacobians_are_the_derivatives(x: float, y: float, yaw: float, mx: float, my: float) -> None:
    mean, landmark, line = np.array([x, y, yaw]), np.array([mx, my]), SeenLine(normal_rad=0.3, distance_m=my)
    np.testing.assert_allclose(
        see_point(mean, landmark)[1], derivative(lambda m: see_point(m, landmark)[0], mean), atol=1e-6
    )
    if abs(wrap_rad(0.3 - yaw)) < 3.1:
        np.testing.assert_allclose(see_line(mean, line)[1], derivative(lambda m: see_line(m, line)[0], mean), atol=1e-6)


@given(coordinates, coordinates, angles)
def test_a_point_is_seen_where_the_pose_has_it(x: float, y: float, yaw: float) -> None:
    pose = Pose2(x_m=x, y_m=y, yaw_rad=yaw)
    seen, _ = see_point(np.array([x, y, yaw]), (5.35, 0.0))
    np.testing.assert_allclose(seen, pose.inverse().transform([(5.35, 0.0)])[0], atol=1e-12)


def test_motion_follows_the_thesis_for_short_steps() -> None:
    mean, speeds, dt_s = np.array([1.0, 2.0, 0.5]), np.array([9.0, 11.0]), 1e-4
    r, b = MODEL.radius_m, MODEL.separation_m
    v, omega = r / 2 * speeds.sum(), r / b * (speeds[1] - speeds[0])
    thesis = mean + dt_s * np.array([v * math.cos(0.5), v * math.sin(0.5), omega])
    np.testing.assert_allclose(move(mean, speeds, dt_s, MODEL), thesis, atol=1e-8)


def test_a_full_turn_on_the_spot_of_a_circle_closes() -> None:
    r, b = MODEL.radius_m, MODEL.separation_m
    omega, v = 0.4, 1.0
    speeds = np.array([(v - omega * b / 2) / r, (v + omega * b / 2) / r])
    mean, steps = np.array([0.0, 0.0, 0.0]), 785
    for _ in range(steps):
        mean = move(mean, speeds, 2 * math.pi / omega / steps, MODEL)
    np.testing.assert_allclose(mean, 0, atol=1e-3)


def test_the_spread_does_not_depend_on_the_sample_rate() -> None:
    spreads = []
    for steps in (50, 200):
        belief = start_belief(Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), (1e-6, 1e-6, 1e-6))
        for _ in range(steps):
            belief = predict(belief, np.array([10.0, 10.0]), 4.0 / steps, MODEL)
        spreads.append(np.sqrt(np.diag(belief.covariance)))
    np.testing.assert_allclose(spreads[0], spreads[1], rtol=0.03)


def test_a_correction_moves_towards_the_landmark_and_shrinks_the_spread() -> None:
    truth = Pose2(x_m=0.1, y_m=-0.1, yaw_rad=0.05)
    belief = start_belief(Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), (0.2, 0.2, 0.1))
    noise = np.eye(2) * 0.02**2
    for landmark in ((2.0, 0.5), (1.5, -1.0)):
        seen = truth.inverse().transform([landmark])[0]
        before = belief
        belief = correct(belief, compare_point(belief, seen, noise, landmark))
        assert np.linalg.eigvalsh(before.covariance - belief.covariance).min() > -1e-12
    assert np.hypot(belief.mean[0] - 0.1, belief.mean[1] + 0.1) < 0.02


def test_repeats_weigh_a_measurement_as_that_part_of_one() -> None:
    belief = start_belief(Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0))
    seen, noise = np.array([2.01, 0.52]), np.diag([0.02, 0.03]) ** 2
    once = correct(belief, compare_point(belief, seen, 8 * noise, (2.0, 0.5)))
    shared = correct(belief, compare_point(belief, seen, noise, (2.0, 0.5)), repeats=8)
    np.testing.assert_allclose(shared.mean, once.mean, atol=1e-12)
    np.testing.assert_allclose(shared.covariance, once.covariance, atol=1e-12)


def test_the_gate_is_the_chi_square_quantile() -> None:
    for dimension, gate in CHI2_99.items():
        assert gate == pytest.approx(chi2.ppf(0.99, dimension), abs=1e-3)
    belief = start_belief(Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0))
    noise = np.eye(2) * 0.02**2
    assert compare_point(belief, np.array([2.03, 0.0]), noise, (2.0, 0.0)).inside_gate
    assert not compare_point(belief, np.array([2.3, 0.0]), noise, (2.0, 0.0)).inside_gate


def test_association_takes_the_nearest_or_none() -> None:
    belief = start_belief(Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0))
    noise, landmarks = np.eye(2) * 0.02**2, ((2.0, 0.5), (2.0, -0.5))
    best = nearest(compare_point(belief, np.array([2.0, 0.47]), noise, landmark) for landmark in landmarks)
    assert best is not None
    np.testing.assert_allclose(best.residual, [0.0, -0.03], atol=1e-12)
    far = nearest(compare_point(belief, np.array([2.0, 0.0]), noise, landmark) for landmark in landmarks)
    assert far is not None and not far.inside_gate
    assert nearest(()) is None


@pytest.mark.parametrize("sense", [0.0, math.pi, -math.pi])
def test_a_line_may_be_seen_from_either_side(sense: float) -> None:
    truth, line = Pose2(x_m=1.0, y_m=-2.55, yaw_rad=0.1), SeenLine(normal_rad=math.pi / 2, distance_m=-2.6125)
    belief = Belief(mean=np.array([1.0, -2.6, 0.05]), covariance=np.diag([0.1, 0.1, 0.1]) ** 2)
    angle, distance = see_line(np.array([truth.x_m, truth.y_m, truth.yaw_rad]), line)[0]
    seen = SeenLine(normal_rad=angle + sense, distance_m=distance if sense == 0 else -distance)
    corrected = correct(belief, compare_line(belief, seen, np.diag([0.001, 0.001]) ** 2, line))
    np.testing.assert_allclose(corrected.mean[1:], [-2.55, 0.1], atol=1e-4)
    np.testing.assert_allclose(corrected.mean[0], 1.0, atol=1e-6)


def test_the_filter_is_consistent_with_the_noise_it_assumes() -> None:
    """Average normalised error squared over many drives round a loop, against its chi-square bounds."""
    rng = np.random.default_rng(11)
    dt_s, runs, steps, sigma = 0.02, 60, 200, 0.05
    speeds, landmarks = np.array([9.5, 11.0]), np.array([[0.0, 2.6], [3.0, 1.0]])
    M = np.diag([MODEL.alpha_own_s * a**2 + MODEL.alpha_other_s * b**2 for a, b in (speeds, speeds[::-1])]) / dt_s
    root = np.linalg.cholesky(M + MODEL.alpha_scale_s / dt_s * np.outer(speeds, speeds))
    errors = []
    for _ in range(runs):
        belief = start_belief(Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0))
        truth = belief.mean + np.sqrt(np.diag(belief.covariance)) * rng.standard_normal(3)
        for k in range(steps):
            truth = move(truth, speeds + root @ rng.standard_normal(2), dt_s, MODEL)
            belief = predict(belief, speeds, dt_s, MODEL)
            if k % 5 == 0:
                landmark = landmarks[k // 5 % 2]
                seen = see_point(truth, landmark)[0] + sigma * rng.standard_normal(2)
                belief = correct(belief, compare_point(belief, seen, np.eye(2) * sigma**2, landmark))
        error = truth - belief.mean
        error[2] = wrap_rad(float(error[2]))
        errors.append(error @ np.linalg.solve(belief.covariance, error))
    low, high = chi2.ppf([0.001, 0.999], 3 * runs) / runs
    assert low < np.mean(errors) < high
