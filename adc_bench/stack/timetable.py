"""How fast a line is driven: the greatest speeds over arc length within what motors, wheels and grip allow.

Every limit is one on v at a place (a, b: half the wheels' separation; k: curvature; c = dk/ds) or on dv/dt there:
    v <= v_max,  v (1 + |k| b) <= rim,  v |k| <= turn rate,  |k| v^2 <= mu g                         at a place;
    |dv/dt| <= a_max,  |d omega/dt| = |c v^2 + k dv/dt| <= a_max / b,  (k v^2)^2 + (dv/dt)^2 <= (mu g)^2   between.
One pass forwards bounds acceleration, one backwards bounds braking.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from adc_bench.stack.reference_line import ReferenceLine
from adc_bench.world.robot import RobotParams

Array = NDArray[np.float64]

GRAVITY_MPS2 = 9.81


@dataclass(frozen=True, kw_only=True)
class SpeedLimits:
    """What a drive may ask of the robot."""

    speed_mps: float
    rim_speed_mps: float
    half_separation_m: float
    turn_rate_radps: float
    acceleration_mps2: float
    turn_acceleration_radps2: float
    grip_mps2: float

    @classmethod
    def of(
        cls, robot: RobotParams, *, speed_mps: float = math.inf, steering_share: float = 0.75, grip_share: float = 0.8
    ) -> "SpeedLimits":
        """Return a robot's nominal limits, at most `speed_mps`, with something in reserve.

        `steering_share` is what the line may use of the wheels' acceleration for turning: the rest is left to correct
        with.
        """
        half_m = robot.wheel_separation_m / 2
        return cls(
            speed_mps=min(speed_mps, robot.speed_max_mps),
            rim_speed_mps=robot.rim_speed_max_mps,
            half_separation_m=half_m,
            turn_rate_radps=robot.turn_rate_max_radps,
            acceleration_mps2=robot.acceleration_max_mps2,
            turn_acceleration_radps2=steering_share * robot.acceleration_max_mps2 / half_m,
            grip_mps2=grip_share * robot.friction * GRAVITY_MPS2,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Timetable:
    """A line with the speed at each of its samples, (n,); between them the acceleration is constant."""

    line: ReferenceLine
    speed_mps: Array

    @cached_property
    def time_s(self) -> Array:
        """When each sample is reached, (n,), from 0."""
        means = (self.speed_mps[1:] + self.speed_mps[:-1]) / 2
        return np.concatenate([[0.0], np.cumsum(np.diff(self.line.s_m) / means)])

    @cached_property
    def _speed_squared(self) -> Array:
        return np.square(self.speed_mps)

    def speed(self, s_m: float) -> float:
        """Return the speed at an arc length, held at the ends."""
        return math.sqrt(float(np.interp(s_m, self.line.s_m, self._speed_squared)))

    def place(self, time_s: float) -> float:
        """Return the arc length reached at a time; its rate of change is `speed` up to the samples' distance."""
        return float(np.interp(time_s, self.time_s, self.line.s_m))


def fastest(line: ReferenceLine, limits: SpeedLimits, start_mps: float = 0.0, end_mps: float = 0.0) -> Timetable:
    """Return the line's fastest timetable; it starts and ends with the given speeds, or less where it must."""
    bend, sharpening = np.abs(line.curvature_pm), np.gradient(line.curvature_pm, line.s_m)
    speeds = _speeds_at_places(bend, np.abs(sharpening), limits)
    speeds[0], speeds[-1] = min(speeds[0], start_mps), min(speeds[-1], end_mps)
    gaps = np.diff(line.s_m)
    forwards = _bounded_gain(speeds, gaps, line.curvature_pm, sharpening, limits)
    backwards = _bounded_gain(forwards[::-1], gaps[::-1], line.curvature_pm[::-1], -sharpening[::-1], limits)
    return Timetable(line=line, speed_mps=backwards[::-1].copy())


def _speeds_at_places(bend: Array, sharpening: Array, limits: SpeedLimits) -> Array:
    with np.errstate(divide="ignore"):
        speeds: Array = np.minimum.reduce(
            [
                np.full_like(bend, limits.speed_mps),
                limits.rim_speed_mps / (1 + bend * limits.half_separation_m),
                limits.turn_rate_radps / bend,
                np.sqrt(limits.grip_mps2 / bend),
                np.sqrt(limits.turn_acceleration_radps2 / sharpening),
            ]
        )
    return speeds


def _bounded_gain(speeds: Array, gaps: Array, curvature: Array, sharpening: Array, limits: SpeedLimits) -> Array:
    """Return the speeds (n,) lowered where, from first to last, they would grow faster than the limits allow."""
    bounded = speeds.copy()
    for k, gap_m in enumerate(gaps.tolist()):
        gain_mps2 = _greatest_gain(bounded[k], curvature[k], sharpening[k], limits)
        bounded[k + 1] = min(bounded[k + 1], math.sqrt(bounded[k] ** 2 + 2 * gain_mps2 * gap_m))
    return bounded


def _greatest_gain(speed_mps: float, curvature_pm: float, sharpening_pm2: float, limits: SpeedLimits) -> float:
    """Return the greatest dv/dt at a place."""
    side_mps2 = curvature_pm * speed_mps**2
    gain = min(limits.acceleration_mps2, math.sqrt(max(limits.grip_mps2**2 - side_mps2**2, 0.0)))
    if curvature_pm != 0.0:
        turning = math.copysign(1.0, curvature_pm) * sharpening_pm2 * speed_mps**2
        gain = min(gain, (limits.turn_acceleration_radps2 - turning) / abs(curvature_pm))
    return max(gain, 0.0)
