"""From a command to wheel speeds: the robot's own controller, which knows only its nominal figures."""

import math

from adc_bench.world.robot import Motion, RobotParams


def limit(robot: RobotParams, wanted: Motion) -> Motion:
    """Return the motion within the speed and turn-rate limits, slowed on the same curve if a rim would be too fast."""
    v_mps = _clip(wanted.v_mps, robot.speed_max_mps)
    omega_radps = _clip(wanted.omega_radps, robot.turn_rate_max_radps)
    rim_mps = abs(v_mps) + abs(omega_radps) * robot.wheel_separation_m / 2
    scale = min(1.0, robot.rim_speed_max_mps / rim_mps) if rim_mps > 0 else 1.0
    return Motion(v_mps=scale * v_mps, omega_radps=scale * omega_radps)


def ramp(robot: RobotParams, now: Motion, target: Motion, dt_s: float) -> Motion:
    """Return the set point one time step nearer to the target.

    Translation and rotation ramp apart, as a Pioneer's firmware does, so that steering never waits for speed: each
    changes a rim's speed by at most `acceleration_max_mps2`.
    """
    dv_mps = robot.acceleration_max_mps2 * dt_s
    domega_radps = dv_mps / (robot.wheel_separation_m / 2)
    return Motion(
        v_mps=now.v_mps + _clip(target.v_mps - now.v_mps, dv_mps),
        omega_radps=now.omega_radps + _clip(target.omega_radps - now.omega_radps, domega_radps),
    )


def wheel_speeds_radps(robot: RobotParams, motion: Motion) -> tuple[float, float]:
    """Return the wheels' angular speeds (left, right) that give the motion on nominal wheels without slip."""
    turning_mps = motion.omega_radps * robot.wheel_separation_m / 2
    return (
        (motion.v_mps - turning_mps) / robot.wheel_radius_m,
        (motion.v_mps + turning_mps) / robot.wheel_radius_m,
    )


def _clip(value: float, bound: float) -> float:
    return math.copysign(min(abs(value), bound), value)
