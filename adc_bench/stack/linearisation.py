"""Trajectory tracking by feedback linearisation about a robot that moves ahead on the trajectory (thesis, section 6).

With e = Rot(yaw)^T (q_d - q), about the trajectory:
    v = v_d cos e3 + k1 e1,   omega = omega_d + k2 sign(v_d) e2 + k3 e3,
    k1 = k3 = 2 zeta sqrt(omega_d^2 + g v_d^2),   k2 = g |v_d|,
the errors obey (lambda + 2 zeta w)(lambda^2 + 2 zeta w lambda + w^2) = 0 with w = sqrt(omega_d^2 + g v_d^2).
"""

import math
from dataclasses import dataclass

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.world.robot import Motion


@dataclass(frozen=True, kw_only=True)
class LinearisationParams:
    """Damping 0 < zeta < 1 and g > 0 in 1/m^2; the thesis leaves their values open."""

    zeta: float = 0.7
    g_pm2: float = 2.0


def follow_moving(pose: Pose2, wanted: Pose2, feed: Motion, params: LinearisationParams) -> Motion:
    """Return the motion at `pose` that follows a robot at `wanted`, which moves with `feed` (v_d, omega_d)."""
    seen = pose.inverse() @ wanted
    turn_error = wrap_rad(seen.yaw_rad)
    gain = 2 * params.zeta * math.sqrt(feed.omega_radps**2 + params.g_pm2 * feed.v_mps**2)
    return Motion(
        v_mps=feed.v_mps * math.cos(turn_error) + gain * seen.x_m,
        omega_radps=feed.omega_radps + params.g_pm2 * feed.v_mps * seen.y_m + gain * turn_error,
    )
