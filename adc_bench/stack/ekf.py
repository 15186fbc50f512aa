"""The extended Kalman filter over [x, y, yaw]: wheel speeds predict, landmarks correct (thesis, section 4).

Where it departs from the thesis, and why:
* the pose advances along an arc (yaw at the middle of the step), where the thesis takes the yaw at its start: a robot
  that always turns the same way would else lag by half a step's turn;
* the wheel noise M is divided by the step's duration, so that the spread per metre does not depend on the sample rate;
* a common scale error of both wheels (unknown tyre radius) is added, which a diagonal M cannot express;
* the gate is the chi-square quantile of the innovation's dimension, not 2 sigma on each axis, which would refuse one
  good landmark in ten;
* beside points (loop centres, crosswalk corners) it takes straight lines, seen as direction and distance.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from adc_bench.geometry import Pose2, wrap_rad

Array = NDArray[np.float64]

CHI2_99 = {1: 6.635, 2: 9.210, 3: 11.345}  # 99 % quantiles by degrees of freedom


@dataclass(frozen=True, kw_only=True)
class WheelModel:
    """Nominal drive and its noise: variance of a wheel's speed is (own w_own^2 + other w_other^2) / dt."""

    radius_m: float
    separation_m: float
    alpha_own_s: float = 2e-5
    alpha_other_s: float = 5e-6
    alpha_scale_s: float = 2e-4


@dataclass(frozen=True, kw_only=True, eq=False)
class Belief:
    """Mean [x_m, y_m, yaw_rad] (3,) and covariance (3, 3)."""

    mean: Array
    covariance: Array

    @property
    def pose(self) -> Pose2:
        """The mean as a pose."""
        return Pose2(x_m=float(self.mean[0]), y_m=float(self.mean[1]), yaw_rad=float(self.mean[2]))


@dataclass(frozen=True, kw_only=True, eq=False)
class Innovation:
    """What a landmark says against the belief: residual (k,), its Jacobian (k, 3) and measurement covariance (k, k)."""

    residual: Array
    jacobian: Array
    noise: Array
    covariance: Array

    @property
    def squared_distance(self) -> float:
        """The squared Mahalanobis distance; chi-square with k degrees of freedom when all is well."""
        return float(self.residual @ np.linalg.solve(self.covariance, self.residual))

    @property
    def inside_gate(self) -> bool:
        """Whether the residual is within the 99 % quantile."""
        return self.squared_distance < CHI2_99[len(self.residual)]


@dataclass(frozen=True, kw_only=True)
class SeenLine:
    """A straight line as the robot sees it: the angle of its unit normal and its signed distance along it."""

    normal_rad: float
    distance_m: float


def start_belief(pose: Pose2, sd: tuple[float, float, float] = (0.02, 0.02, 0.05)) -> Belief:
    """Return the belief at a known start: the thesis' Sigma0, read as standard deviations in metres and radians."""
    return Belief(mean=np.array([pose.x_m, pose.y_m, pose.yaw_rad]), covariance=np.diag(np.square(sd)))


def move(mean: Array, wheels_radps: Array, dt_s: float, model: WheelModel) -> Array:
    """Return g(u, mu): the pose (3,) after `dt_s` with wheel speeds [left, right] (2,)."""
    speed, turn = _body_speeds(wheels_radps, model)
    middle = mean[2] + turn * dt_s / 2
    return np.array(
        [
            mean[0] + speed * dt_s * math.cos(middle),
            mean[1] + speed * dt_s * math.sin(middle),
            wrap_rad(mean[2] + turn * dt_s),
        ]
    )


def move_jacobians(mean: Array, wheels_radps: Array, dt_s: float, model: WheelModel) -> tuple[Array, Array]:
    """Return G = dg/dmu (3, 3) and V = dg/du (3, 2)."""
    speed, turn = _body_speeds(wheels_radps, model)
    middle = mean[2] + turn * dt_s / 2
    c, s = math.cos(middle), math.sin(middle)
    G = np.array([[1.0, 0.0, -speed * dt_s * s], [0.0, 1.0, speed * dt_s * c], [0.0, 0.0, 1.0]])
    half_turn = model.radius_m / model.separation_m * dt_s / 2
    by_turn = np.array([-speed * dt_s * s, speed * dt_s * c]) * half_turn
    forward = model.radius_m / 2 * dt_s * np.array([c, s])
    V = np.column_stack([[*(forward - by_turn), -2 * half_turn], [*(forward + by_turn), 2 * half_turn]])
    return G, V


def predict(belief: Belief, wheels_radps: Array, dt_s: float, model: WheelModel) -> Belief:
    """Return the belief after `dt_s` with wheel speeds [left, right]: Sigma = G Sigma G^T + V M V^T."""
    G, V = move_jacobians(belief.mean, wheels_radps, dt_s, model)
    left, right = np.square(wheels_radps)
    own, other = model.alpha_own_s, model.alpha_other_s
    M = np.diag([own * left + other * right, own * right + other * left]) / dt_s
    M += model.alpha_scale_s / dt_s * np.outer(wheels_radps, wheels_radps)
    covariance = G @ belief.covariance @ G.T + V @ M @ V.T
    return Belief(mean=move(belief.mean, wheels_radps, dt_s, model), covariance=covariance)


def see_point(mean: Array, landmark_world: ArrayLike) -> tuple[Array, Array]:
    """Return h(mu) = Rot(yaw)^T (m - [x, y]) (2,) and its Jacobian H (2, 3)."""
    dx, dy = np.asarray(landmark_world, dtype=np.float64) - mean[:2]
    c, s = math.cos(mean[2]), math.sin(mean[2])
    seen = np.array([c * dx + s * dy, -s * dx + c * dy])
    return seen, np.array([[-c, -s, seen[1]], [s, -c, -seen[0]]])


def see_line(mean: Array, line_world: SeenLine) -> tuple[Array, Array]:
    """Return the line's [normal angle, distance] in the robot frame (2,) and the Jacobian (2, 3)."""
    c, s = math.cos(line_world.normal_rad), math.sin(line_world.normal_rad)
    distance = line_world.distance_m - c * mean[0] - s * mean[1]
    seen = np.array([wrap_rad(line_world.normal_rad - mean[2]), distance])
    return seen, np.array([[0.0, 0.0, -1.0], [-c, -s, 0.0]])


def compare_point(belief: Belief, seen_robot: Array, noise: Array, landmark_world: ArrayLike) -> Innovation:
    """Return the innovation of a point landmark seen at (2,) in the robot frame with covariance (2, 2)."""
    expected, H = see_point(belief.mean, landmark_world)
    return _innovation(belief, seen_robot - expected, H, noise)


def compare_line(belief: Belief, seen: SeenLine, noise: Array, line_world: SeenLine) -> Innovation:
    """Return the innovation of a straight line; the normals' senses may differ by half a turn."""
    expected, H = see_line(belief.mean, line_world)
    angle, distance = seen.normal_rad, seen.distance_m
    if abs(wrap_rad(angle - expected[0])) > math.pi / 2:
        angle, distance = angle + math.pi, -distance
    return _innovation(belief, np.array([wrap_rad(angle - expected[0]), distance - expected[1]]), H, noise)


def nearest(innovations: Iterable[Innovation]) -> Innovation | None:
    """Return the innovation of the nearest candidate, inside its gate or not; None where there is none."""
    return min(innovations, key=lambda innovation: innovation.squared_distance, default=None)


def correct(belief: Belief, innovation: Innovation, repeats: float = 1.0) -> Belief:
    """Return the belief after an innovation; Joseph's form keeps the covariance symmetric and positive.

    `repeats` is how many measurements running share one error (camera tilt, uneven paint): each counts as that part of
    an independent one, its noise taken so many times larger. The gate judges the single measurement, without it.
    """
    H, Q = innovation.jacobian, innovation.noise * repeats
    S = innovation.covariance + (repeats - 1) * innovation.noise
    K = np.linalg.solve(S, H @ belief.covariance).T
    mean = belief.mean + K @ innovation.residual
    mean[2] = wrap_rad(float(mean[2]))
    keep = np.eye(3) - K @ H
    return Belief(mean=mean, covariance=keep @ belief.covariance @ keep.T + K @ Q @ K.T)


def _innovation(belief: Belief, residual: Array, jacobian: Array, noise: Array) -> Innovation:
    covariance = jacobian @ belief.covariance @ jacobian.T + noise
    return Innovation(residual=residual, jacobian=jacobian, noise=noise, covariance=covariance)


def _body_speeds(wheels_radps: Array, model: WheelModel) -> tuple[float, float]:
    left, right = wheels_radps
    return model.radius_m / 2 * float(left + right), model.radius_m / model.separation_m * float(right - left)
