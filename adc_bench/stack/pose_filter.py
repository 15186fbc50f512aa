"""The reference's filter: pose, sensor errors and camera tilt in one extended Kalman filter.

The state is [x_m, y_m, yaw_rad, gyro bias, wheel scale, camera pitch, camera roll]: what the mission leaves unknown and
a drive makes known. Travel and turn predict, residuals of any kind correct.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.ekf import Belief

Array = NDArray[np.float64]

YAW, GYRO_BIAS, SCALE, PITCH, ROLL = 2, 3, 4, 5, 6
SIZE = 7


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimate:
    """Mean (7,) and covariance (7, 7); unknowns of a single measurement may follow the seven for its time."""

    mean: Array
    covariance: Array

    @property
    def belief(self) -> Belief:
        """The pose alone, with its covariance."""
        return Belief(mean=self.mean[:3], covariance=self.covariance[:3, :3])

    @property
    def tilt_rad(self) -> tuple[float, float]:
        """The camera's pitch and roll against its nominal mount."""
        return float(self.mean[PITCH]), float(self.mean[ROLL])


@dataclass(frozen=True, kw_only=True)
class StartSpread:
    """Standard deviations at the start: the robot's as they are drawn, the pose's as it is put down."""

    position_m: float = 0.01
    yaw_rad: float = math.radians(0.5)
    gyro_bias_radps: float = math.radians(0.5)
    wheel_scale: float = 0.003
    tilt_rad: float = math.radians(0.3)


@dataclass(frozen=True, kw_only=True)
class MotionNoise:
    """What travel and turn leave open; variances grow with the way, so that they do not depend on the sampling.

    Attributes:
        along_m_sqrtm: sd of the travel over one metre.
        across_m_sqrtm: sd of the drift aside over one metre; wheels creep in bends.
        yaw_rad_sqrts: sd of the yaw over one second: the gyro's noise.
        bias_radps_sqrts: sd of the gyro bias' change over one second.
        tilt_rad_sqrtm: sd of the tilt's change over one metre: what the picture's geometry shows of it differs from
            place to place.
    """

    along_m_sqrtm: float = 0.002
    across_m_sqrtm: float = 0.002
    yaw_rad_sqrts: float = math.radians(0.012)
    bias_radps_sqrts: float = math.radians(0.005)
    tilt_rad_sqrtm: float = math.radians(0.007)


@dataclass(frozen=True, kw_only=True, eq=False)
class Travel:
    """What encoders and gyro say of a span of time, step by step.

    Attributes:
        duration_s: (n,) of the steps.
        forward_m: (n,) by the nominal wheels.
        turn_rad: (n,) by the gyro, its bias included.
        slip_m: how far the wheels' and the gyro's turns disagree, as a way of one wheel.
    """

    duration_s: Array
    forward_m: Array
    turn_rad: Array
    slip_m: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Residuals:
    """Scalar measurements: residuals (n,) seen less expected, Jacobian (n, 7) of the expected, variances (n,)."""

    values: Array
    jacobian: Array
    variances: Array


def start_estimate(pose: Pose2, spread: StartSpread) -> Estimate:
    """Return the estimate at a known start, the robot and its camera as their data sheets say."""
    mean = np.array([pose.x_m, pose.y_m, pose.yaw_rad, 0.0, 0.0, 0.0, 0.0])
    sd = [
        spread.position_m,
        spread.position_m,
        spread.yaw_rad,
        spread.gyro_bias_radps,
        spread.wheel_scale,
        spread.tilt_rad,
        spread.tilt_rad,
    ]
    return Estimate(mean=mean, covariance=np.diag(np.square(sd)))


def widened(estimate: Estimate, position_m: float, yaw_rad: float) -> Estimate:
    """Return the estimate with this much doubt more about its pose, as standard deviations."""
    more = np.zeros(SIZE)
    more[:3] = position_m, position_m, yaw_rad
    return Estimate(mean=estimate.mean, covariance=estimate.covariance + np.diag(np.square(more)))


def move(mean: Array, travel: Travel) -> Array:
    """Return the mean (7,) after a travel: each step is a chord at the yaw of its middle."""
    turns = travel.turn_rad - mean[GYRO_BIAS] * travel.duration_s
    yaw = mean[YAW] + np.cumsum(turns) - turns / 2
    forward_m = (1 + mean[SCALE]) * travel.forward_m
    moved = mean.copy()
    moved[0] += forward_m @ np.cos(yaw)
    moved[1] += forward_m @ np.sin(yaw)
    moved[YAW] = wrap_rad(float(mean[YAW] + turns.sum()))
    return moved


def move_jacobian(mean: Array, travel: Travel) -> Array:
    """Return (7, 7): how the mean after a travel depends on the one before it."""
    dt = travel.duration_s
    turns = travel.turn_rad - mean[GYRO_BIAS] * dt
    yaw = mean[YAW] + np.cumsum(turns) - turns / 2
    elapsed_s = np.cumsum(dt) - dt / 2
    forward_m = (1 + mean[SCALE]) * travel.forward_m
    c, s = np.cos(yaw), np.sin(yaw)
    F = np.eye(SIZE)
    F[0, YAW], F[1, YAW] = -forward_m @ s, forward_m @ c
    F[0, GYRO_BIAS], F[1, GYRO_BIAS] = forward_m @ (s * elapsed_s), -forward_m @ (c * elapsed_s)
    F[0, SCALE], F[1, SCALE] = travel.forward_m @ c, travel.forward_m @ s
    F[YAW, GYRO_BIAS] = -dt.sum()
    return F


def motion_noise(mean: Array, travel: Travel, noise: MotionNoise) -> Array:
    """Return (7, 7): what a travel adds to the covariance."""
    way_m, duration_s = float(np.abs(travel.forward_m).sum()), float(travel.duration_s.sum())
    yaw = float(mean[YAW] + travel.turn_rad.sum() / 2)
    turned = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    along, across = noise.along_m_sqrtm**2 * way_m + travel.slip_m**2, noise.across_m_sqrtm**2 * way_m
    Q = np.zeros((SIZE, SIZE))
    Q[:2, :2] = turned @ np.diag([along, across]) @ turned.T
    Q[YAW, YAW] = noise.yaw_rad_sqrts**2 * duration_s
    Q[GYRO_BIAS, GYRO_BIAS] = noise.bias_radps_sqrts**2 * duration_s
    Q[PITCH, PITCH] = Q[ROLL, ROLL] = noise.tilt_rad_sqrtm**2 * way_m
    return Q


def predict(estimate: Estimate, travel: Travel, noise: MotionNoise) -> Estimate:
    """Return the estimate after a travel: P = F P F^T + Q."""
    F = move_jacobian(estimate.mean, travel)
    covariance = F @ estimate.covariance @ F.T + motion_noise(estimate.mean, travel, noise)
    return Estimate(mean=move(estimate.mean, travel), covariance=covariance)


def correct(estimate: Estimate, residuals: Residuals) -> Estimate:
    """Return the estimate after measurements, in the information form: many scalars cost no more than few.

    P' = (P^-1 + H^T R^-1 H)^-1, mean' = mean + P' H^T R^-1 r; the Kalman update of all rows at once.
    """
    weighted = residuals.jacobian / residuals.variances[:, None]
    covariance = np.linalg.inv(np.linalg.inv(estimate.covariance) + residuals.jacobian.T @ weighted)
    covariance = (covariance + covariance.T) / 2
    mean = estimate.mean + covariance @ (weighted.T @ residuals.values)
    mean[YAW] = wrap_rad(float(mean[YAW]))
    return Estimate(mean=mean, covariance=covariance)


def squared_distance(estimate: Estimate, residuals: Residuals) -> tuple[float, int]:
    """Return the innovation's squared Mahalanobis distance and its degrees of freedom (the rank of what was seen).

    With the information L = H^T R^-1 H and b = H^T R^-1 r of all rows it is b^T (L + L P L)^+ b: that of the
    compressed measurement L^+ b, whose covariance is L^+ + P.
    """
    weighted = residuals.jacobian / residuals.variances[:, None]
    information = residuals.jacobian.T @ weighted
    scale = np.sqrt(np.diag(estimate.covariance))
    information = information * np.outer(scale, scale)
    prior = estimate.covariance / np.outer(scale, scale)
    b = scale * (weighted.T @ residuals.values)
    values, vectors = np.linalg.eigh(information)
    seen = values > values[-1] * 1e-9
    basis = vectors[:, seen]
    spread = np.diag(values[seen]) + np.diag(values[seen]) @ basis.T @ prior @ basis @ np.diag(values[seen])
    told = basis.T @ b
    return float(told @ np.linalg.solve(spread, told)), int(seen.sum())
