"""How good pose estimates are: plain functions of arrays."""

import math
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from adc_bench.evaluate.recorded_log import Encoders
from adc_bench.evaluate.trajectory_error import aligned, relative_errors
from adc_bench.geometry import Pose2, wrap_array_rad
from adc_bench.world.robot import RobotParams

Array = NDArray[np.float64]
COVERED_NEES = float(chi2.ppf(0.95, df=3))
RPE_STEPS = 20  # a second


class Localization(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Errors of a drive's estimates from the arrow on, of a recording's from its beginning, in the map's frame,
    unaligned but for `ate_rmse_m`: that is the error left when the whole path is laid onto the true one. `rpe_*`: the
    error of the motion over a second.

    `nees_mean` (ideally 3) and `coverage` (ideally 0.95: the share of poses inside the estimate's own 95 % region)
    stand only if the submission gives covariances. Dead reckoning is replayed from the same run's encoders with the
    robot's nominal figures.
    """

    position_rmse_m: float
    position_p95_m: float
    position_max_m: float
    heading_rmse_rad: float
    ate_rmse_m: float
    rpe_rmse_m: float | None  # none if there are no poses a second apart
    rpe_rmse_rad: float | None
    nees_mean: float | None
    coverage: float | None
    dead_reckoning_rmse_m: float
    dead_reckoning_max_m: float


def rms(values: Array) -> float:
    """Return the root mean square."""
    return math.sqrt(float(np.mean(np.square(values))))


def position_errors_m(truth: Array, estimate: Array) -> Array:
    """Return the distances (n,) between poses (n, 3) and their estimates."""
    errors: Array = np.hypot(estimate[:, 0] - truth[:, 0], estimate[:, 1] - truth[:, 1])
    return errors


def nees(truth: Array, estimate: Array, covariance: Array) -> Array:
    """Return e^T P^-1 e (n,) for poses (n, 3) and covariances (n, 3, 3); inf where P is not positive definite."""
    error = estimate - truth
    error[:, 2] = wrap_array_rad(error[:, 2])
    symmetric = (covariance + covariance.transpose(0, 2, 1)) / 2
    sound = np.linalg.eigvalsh(symmetric)[:, 0] > 0.0
    values = np.full(len(error), np.inf)
    solved = np.linalg.solve(symmetric[sound], error[sound][..., None])[..., 0]
    values[sound] = np.sum(error[sound] * solved, axis=1)
    return values


def dead_reckoning(
    start: Pose2, robot: RobotParams, sample_s: Array, left_ticks: Array, right_ticks: Array, times_s: Array
) -> Array:
    """Return positions (m, 2) at `times_s` (m,) from cumulative ticks (n,) at `sample_s` (n,), n >= 1.

    Each step is an arc's chord with the nominal wheel radius and separation; between samples it is interpolated.
    """
    m_per_tick = 2 * math.pi * robot.wheel_radius_m / robot.encoder_ticks_per_turn
    left_m, right_m = np.diff(left_ticks) * m_per_tick, np.diff(right_ticks) * m_per_tick
    turn = (right_m - left_m) / robot.wheel_separation_m
    yaw_before = start.yaw_rad + np.concatenate([[0.0], np.cumsum(turn)])
    middle = yaw_before[:-1] + turn / 2
    along_m = (left_m + right_m) / 2
    x = start.x_m + np.concatenate([[0.0], np.cumsum(along_m * np.cos(middle))])
    y = start.y_m + np.concatenate([[0.0], np.cumsum(along_m * np.sin(middle))])
    return np.stack([np.interp(times_s, sample_s, x), np.interp(times_s, sample_s, y)], axis=1)


def replayed(start: Pose2, robot: RobotParams, encoders: Sequence[Encoders], times_s: Sequence[float]) -> Array:
    """Return where dead reckoning from a run's own encoders would be at these times, (n, 2)."""
    return dead_reckoning(
        start,
        robot,
        np.array([time_s for samples in encoders for time_s in samples.time_s]),
        np.array([ticks for samples in encoders for ticks in samples.left_ticks], dtype=np.float64),
        np.array([ticks for samples in encoders for ticks in samples.right_ticks], dtype=np.float64),
        np.array(times_s),
    )


def pose_array(poses: Sequence[Pose2]) -> Array:
    """Return poses as an array (n, 3)."""
    return np.array([(pose.x_m, pose.y_m, pose.yaw_rad) for pose in poses], dtype=np.float64).reshape(-1, 3)


def localization(truth: Array, estimate: Array, covariance: Array | None, reckoned: Array) -> Localization:
    """Return the errors of estimates (n, 3) and of dead reckoning (n, 2) against true poses (n, 3), n >= 1."""
    position_m = position_errors_m(truth, estimate)
    reckoning_m = position_errors_m(truth, reckoned)
    values = None if covariance is None else nees(truth, estimate, covariance)
    finite = None if values is None else values[np.isfinite(values)]
    drift_m, drift_rad = relative_errors(truth, estimate, RPE_STEPS)
    return Localization(
        position_rmse_m=rms(position_m),
        position_p95_m=float(np.quantile(position_m, 0.95)),
        position_max_m=float(position_m.max()),
        heading_rmse_rad=rms(wrap_array_rad(estimate[:, 2] - truth[:, 2])),
        ate_rmse_m=rms(position_errors_m(truth, aligned(truth, estimate))),
        rpe_rmse_m=rms(drift_m) if drift_m.size else None,
        rpe_rmse_rad=rms(drift_rad) if drift_rad.size else None,
        nees_mean=float(finite.mean()) if finite is not None and finite.size else None,
        coverage=None if values is None else float(np.mean(values <= COVERED_NEES)),
        dead_reckoning_rmse_m=rms(reckoning_m),
        dead_reckoning_max_m=float(reckoning_m.max()),
    )
