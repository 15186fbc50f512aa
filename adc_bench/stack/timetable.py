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
        cls, robot: RobotParams, *, speed_mps: float = math.inf, steering_share: float = 0.75, grip_share: float = 0.5
    ) -> "SpeedLimits":
        """Return a robot's nominal limits, at most `speed_mps`, with something in reserve.

        `steering_share` is what the line may use of the wheels' acceleration for turning: the rest is left to correct
        with. `grip_share` is low because a castor that holds nothing aside carries a fifth of the weight.
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
    bend, gaps = line.curvature_pm, np.diff(line.s_m)
    middle_bend, sharpening = (bend[1:] + bend[:-1]) / 2, np.diff(bend) / gaps
    speeds = _speeds_at_places(np.abs(bend), np.abs(sharpening), limits)
    speeds[0], speeds[-1] = min(speeds[0], start_mps), min(speeds[-1], end_mps)
    forwards = _bounded_gain(speeds, gaps, middle_bend, sharpening, limits)
    backwards = _bounded_gain(forwards[::-1], gaps[::-1], middle_bend[::-1], -sharpening[::-1], limits)
    return Timetable(line=line, speed_mps=backwards[::-1].copy())


def _speeds_at_places(bend: Array, sharpening: Array, limits: SpeedLimits) -> Array:
    """Return the greatest speeds (n,) at samples with these bends (n,) and, between them, changes of bend (n - 1,)."""
    around = np.maximum(np.append(sharpening, 0.0), np.append(0.0, sharpening))
    with np.errstate(divide="ignore"):
        speeds: Array = np.minimum.reduce(
            [
                np.full_like(bend, limits.speed_mps),
                limits.rim_speed_mps / (1 + bend * limits.half_separation_m),
                limits.turn_rate_radps / bend,
                np.sqrt(limits.grip_mps2 / bend),
                np.sqrt(limits.turn_acceleration_radps2 / around),
            ]
        )
    return speeds


def _bounded_gain(speeds: Array, gaps: Array, bend: Array, sharpening: Array, limits: SpeedLimits) -> Array:
    """Return the speeds (n,) lowered where, from first to last, they would grow faster than the limits allow."""
    squares = np.square(speeds).tolist()
    for k, (gap_m, k_pm, c_pm2) in enumerate(zip(gaps.tolist(), bend.tolist(), sharpening.tolist(), strict=True)):
        gain_mps2 = _greatest_gain(squares[k], gap_m, k_pm, c_pm2, limits)
        squares[k + 1] = min(squares[k + 1], squares[k] + 2 * gain_mps2 * gap_m)
    bounded: Array = np.sqrt(squares)
    return bounded


def _greatest_gain(square: float, gap_m: float, bend_pm: float, sharpening_pm2: float, limits: SpeedLimits) -> float:
    """Return the greatest dv/dt from one sample to the next, from the square of the speed at the first.

    In the middle of the gap that square has grown by dv/dt times the gap.
    """
    side_mps2 = bend_pm * (square + limits.acceleration_mps2 * gap_m)
    gain = min(limits.acceleration_mps2, math.sqrt(max(limits.grip_mps2**2 - side_mps2**2, 0.0)))
    per_gain = bend_pm + sharpening_pm2 * gap_m
    if per_gain:
        turning = math.copysign(sharpening_pm2 * square, sharpening_pm2 * per_gain)
        gain = min(gain, (limits.turn_acceleration_radps2 - turning) / abs(per_gain))
    return max(gain, 0.0)
