"""The fastest way along a line: speeds over arc length at the limits of motors, wheels and grip.

With k the curvature, c = dk/ds, h half the wheels' separation and b = v^2, every limit is a bound on b at a place,
    v <= v_max,  v (1 + |k| h) <= rim,  v |k| <= turn rate,  |k| v^2 <= side,
or, between two samples g apart (in whose middle v^2 is b + g a), a linear one on b and the acceleration a,
    |a| <= a_max,  |d omega/dt| = |c (b + g a) + k a| <= alpha_max.
One pass backwards finds from which speeds the rest of the line can be driven at all, one forwards takes at each place
the greatest acceleration that stays among them: the reachability analysis of time-optimal path parameterisation.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adc_bench.stack.reference_line import ReferenceLine
from adc_bench.world.robot import RobotParams

Array = NDArray[np.float64]

Line = tuple[float, float]

GRAVITY_MPS2 = 9.81
TINY_PM = 1e-9  # a straight's bend, so that one may divide by it


@dataclass(frozen=True, kw_only=True)
class SpeedLimits:
    """What a drive may ask of the robot."""

    speed_mps: float
    rim_speed_mps: float
    half_separation_m: float
    turn_rate_radps: float
    side_mps2: float
    acceleration_mps2: float
    turn_acceleration_radps2: float

    @classmethod
    def of(
        cls, robot: RobotParams, *, speed_mps: float = math.inf, steering_share: float = 0.75, grip_share: float = 0.5
    ) -> "SpeedLimits":
        """Return a robot's nominal limits, at most `speed_mps`, with something in reserve.

        `steering_share` is what the line may use of the wheels' acceleration for turning: the rest is left to correct
        with. `grip_share` is low because a castor that holds nothing aside carries a fifth of the weight.
        """
        half_m, grip_mps2 = robot.wheel_separation_m / 2, grip_share * robot.friction * GRAVITY_MPS2
        return cls(
            speed_mps=min(speed_mps, robot.speed_max_mps),
            rim_speed_mps=robot.rim_speed_max_mps,
            half_separation_m=half_m,
            turn_rate_radps=robot.turn_rate_max_radps,
            side_mps2=0.8 * grip_mps2,
            acceleration_mps2=min(robot.acceleration_max_mps2, 0.6 * grip_mps2),  # 0.8 and 0.6: a point of the circle
            turn_acceleration_radps2=steering_share * robot.acceleration_max_mps2 / half_m,
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
    gaps = np.diff(line.s_m)
    stretches = _stretches(line.curvature_pm, gaps, limits)
    square = np.square(_speeds_at_places(np.abs(line.curvature_pm), limits))
    square[0], square[-1] = min(square[0], start_mps**2), min(square[-1], end_mps**2)
    reach = square.tolist()
    for k in range(len(stretches) - 1, -1, -1):
        reach[k] = min(reach[k], stretches[k].greatest_square(reach[k + 1]))
    for k, stretch in enumerate(stretches):
        reach[k + 1] = stretch.next_square(reach[k], reach[k + 1])
    return Timetable(line=line, speed_mps=np.sqrt(reach))


def _speeds_at_places(bend: Array, limits: SpeedLimits) -> Array:
    """Return the greatest speeds (n,) at samples with these bends (n,)."""
    with np.errstate(divide="ignore"):
        speeds: Array = np.minimum.reduce(
            [
                np.full_like(bend, limits.speed_mps),
                limits.rim_speed_mps / (1 + bend * limits.half_separation_m),
                limits.turn_rate_radps / bend,
                np.sqrt(limits.side_mps2 / bend),
            ]
        )
    return speeds


class _Stretch(NamedTuple):
    """From one sample to the next: |a| <= most and -turn <= a - per_square b <= turn, b being v^2 at the first."""

    gap_m: float
    most: float
    turn: float
    per_square: float

    def bounds(self, after: float) -> tuple[tuple[Line, ...], tuple[Line, ...]]:
        """Return what bounds a from below and from above, as (constant, slope in b), where v^2 is to end in
        [0, after].
        """
        slope = -1 / (2 * self.gap_m)
        below = ((-self.most, 0.0), (-self.turn, self.per_square), (0.0, slope))
        above = ((self.most, 0.0), (self.turn, self.per_square), (-slope * after, slope))
        return below, above

    def greatest_square(self, after: float) -> float:
        """Return the greatest b from which some a ends in [0, after]: below it no lower bound exceeds an upper one."""
        below, above = self.bounds(after)
        return min(((r - p) / (q - s) for p, q in below for r, s in above if q > s), default=math.inf)

    def next_square(self, square: float, after: float) -> float:
        """Return v^2 at the end under the greatest a."""
        _, above = self.bounds(after)
        gained = 2 * self.gap_m * min(r + s * square for r, s in above)
        return min(max(square + gained, 0.0), after)


def _stretches(bend: Array, gaps: Array, limits: SpeedLimits) -> list[_Stretch]:
    sharpening = np.diff(bend) / gaps
    per_gain = (bend[1:] + bend[:-1]) / 2 + sharpening * gaps
    per_gain = np.where(np.abs(per_gain) < TINY_PM, TINY_PM, per_gain)
    turn = limits.turn_acceleration_radps2 / np.abs(per_gain)
    most = np.full_like(gaps, limits.acceleration_mps2)
    return [_Stretch(*row) for row in np.stack([gaps, most, turn, -sharpening / per_gain], axis=1).tolist()]
