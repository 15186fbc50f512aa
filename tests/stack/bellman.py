"""The least time along a line by Bellman's principle: no part of the timetable's way of finding it."""

import math

import numpy as np

from adc_bench.stack.reference_line import ReferenceLine
from adc_bench.stack.timetable import SpeedLimits

CELLS = 16  # of the grid over v^2, that full throttle passes from one place to the next


def least_time_s(line: ReferenceLine, limits: SpeedLimits, start_mps: float, step_m: float = 0.02) -> float:
    """Return the least time along a line from a speed to any, on a grid of places and of squared speeds."""
    count = int(line.length_m / step_m)
    s_m, step_m = np.linspace(0.0, line.length_m, count + 1, retstep=True)
    bend = np.interp(s_m, line.s_m, line.curvature_pm)
    cell = 2 * limits.acceleration_mps2 * step_m / CELLS
    squares = cell * np.arange(math.floor(limits.speed_mps**2 / cell) + 1)
    reached = np.arange(len(squares))[:, None] + np.arange(-CELLS, CELLS + 1)
    there = (reached >= 0) & (reached < len(squares))
    reached = np.clip(reached, 0, len(squares) - 1)
    now, then = squares[:, None], squares[reached]
    gain, middle = (then - now) / (2 * step_m), (then + now) / 2
    with np.errstate(divide="ignore"):
        step_s = np.where(there, 2 * step_m / (np.sqrt(now) + np.sqrt(then)), np.inf)
    left_s = np.zeros(len(squares))
    for first, second in zip(bend[-2::-1], bend[:0:-1], strict=True):
        here, sharpening = (first + second) / 2, (second - first) / step_m
        fastest_mps2 = (
            min(
                limits.side_mps2 / abs(here),
                (limits.rim_speed_mps / (1 + abs(here) * limits.half_separation_m)) ** 2,
                (limits.turn_rate_radps / abs(here)) ** 2,
            )
            if here
            else math.inf
        )
        turning = np.abs(sharpening * middle + here * gain)
        allowed = (middle <= fastest_mps2) & (turning <= limits.turn_acceleration_radps2)
        left_s = np.where(allowed, step_s + left_s[reached], np.inf).min(axis=1)
    return float(np.interp(start_mps, np.sqrt(squares), left_s)) if start_mps else float(left_s[0])
