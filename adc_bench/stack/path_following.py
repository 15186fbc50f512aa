"""Path following: PID on the heading error towards a point ahead on the lane (thesis, section 6).

The thesis steers by the error alone, so it begins a bend one look-ahead early and cuts it: by 0.18 m where the loops
meet the S-roads at 1 m/s, more than the 0.17 m between a wheel and the line. Here the lane's own curvature is fed
forward, and the error is what remains: the direction to the point ahead, less that in which a robot on the lane would
see it.
"""

import math
from dataclasses import dataclass, replace

from adc_bench.geometry import Path, Pose2, wrap_rad


@dataclass(frozen=True, kw_only=True)
class FollowParams:
    """Gains of the thesis; `integral_max_rad_s` bounds what a long bend can wind up."""

    kp: float = 1.6
    ki: float = 0.01
    kd: float = 0.4
    integral_max_rad_s: float = 2.0
    look_ahead_m: float = 0.6


@dataclass(frozen=True, kw_only=True)
class Follower:
    """Progress along the lap from the start line on (it grows beyond a lap), and the controller's memory."""

    s_m: float
    integral_rad_s: float = 0.0
    error_rad: float | None = None


def follow(
    state: Follower, pose: Pose2, lap: Path, speed_mps: float, dt_s: float, params: FollowParams
) -> tuple[Follower, float]:
    """Return the next state and omega in rad/s: v kappa + Kp e + Ki int(e) + Kd de/dt."""
    s_m = progress(state.s_m, pose, lap)
    on_lane, target = lap.pose(s_m), lap.pose(s_m + params.look_ahead_m)
    error = wrap_rad(_bearing(pose, target) - _bearing(on_lane, target))
    bound = params.integral_max_rad_s
    integral = max(-bound, min(bound, state.integral_rad_s + error * dt_s))
    rate = 0.0 if state.error_rad is None else wrap_rad(error - state.error_rad) / dt_s
    forward = speed_mps * float(lap.curvature_pm(s_m)[0])
    omega_radps = forward + params.kp * error + params.ki * integral + params.kd * rate
    return replace(state, s_m=s_m, integral_rad_s=integral, error_rad=error), omega_radps


def _bearing(pose: Pose2, target: Pose2) -> float:
    """Return the direction of the target, seen from the pose."""
    return math.atan2(target.y_m - pose.y_m, target.x_m - pose.x_m) - pose.yaw_rad


def progress(s_m: float, pose: Pose2, lap: Path) -> float:
    """Return the arc length at the pose, on the branch and in the lap of the last one."""
    around = s_m % lap.length_m
    nearest, _ = lap.project([(pose.x_m, pose.y_m)], around_s_m=around)
    return s_m + wrap_to(float(nearest[0]) - around, lap.length_m)


def wrap_to(distance_m: float, period_m: float) -> float:
    """Return the distance in [-period/2, period/2)."""
    return (distance_m + period_m / 2) % period_m - period_m / 2
