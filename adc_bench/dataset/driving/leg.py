"""A leg: a stretch that a driver drives in one go, forwards or backwards, from rest to rest."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from adc_bench.geometry import Path
from adc_bench.world.categories import PanelSign

Array = NDArray[np.float64]
STEP_M = 0.02  # between a leg's stations
ROUNDING_M = 0.30  # sd of the filter that rounds the corners of a leg's course

Knots = Sequence[tuple[float, float]]  # (arc length, offset to the left), both in metres, in order


@dataclass(frozen=True, kw_only=True, eq=False)
class Leg:
    """What is to be driven: along `path` from `start_m` to `end_m`, `aside_m` to its left, at `speed_mps`.

    Attributes:
        aside_m, speed_mps: (n,) at the stations 0, STEP_M, 2 STEP_M, ... of the path.
        backwards: the robot drives tail first; the path is that of its motion.
        wait_s: how long it stands before it sets out.
        signs: what the panels show from which arc length on. What holds at `start_m` appears half-way through the wait.
    """

    path: Path
    start_m: float
    end_m: float
    aside_m: Array
    speed_mps: Array
    backwards: bool = False
    wait_s: float = 0.0
    signs: tuple[tuple[float, PanelSign], ...] = ()

    @cached_property
    def stations_m(self) -> Array:
        """The arc lengths (n,) at which the leg is given."""
        return stations_m(self.path)

    @cached_property
    def line(self) -> Array:
        """The line to be driven at the stations, (n, 4): x, y, heading of the motion, curvature."""
        return driven_line(self.path, self.aside_m)

    def at(self, s_m: float) -> tuple[float, float, float, float, float]:
        """Return x, y, heading, curvature and speed wanted at an arc length."""
        row = np.clip(s_m / STEP_M, 0, len(self.line) - 1)
        low = int(min(row, len(self.line) - 2))
        x, y, heading, curvature = ((1 - row + low) * self.line[low] + (row - low) * self.line[low + 1]).tolist()
        return x, y, heading, curvature, float(np.interp(s_m, self.stations_m, self.speed_mps))

    @cached_property
    def poses(self) -> Array:
        """The robot's wanted poses (m, 3) from start to end."""
        driven = (self.stations_m >= self.start_m - STEP_M / 2) & (self.stations_m <= self.end_m + STEP_M / 2)
        return self.line[driven, :3] + (0.0, 0.0, np.pi if self.backwards else 0.0)


def stations_m(path: Path) -> Array:
    """Return the arc lengths of a path's stations."""
    return np.arange(int(path.length_m / STEP_M) + 1, dtype=np.float64) * STEP_M


def course_aside(path: Path, knots: Knots) -> Array:
    """Return offsets (n,) at the path's stations: straight from knot to knot, the corners rounded."""
    at_m, aside_m = np.array(knots).T
    rounded: Array = gaussian_filter1d(np.interp(stations_m(path), at_m, aside_m), ROUNDING_M / STEP_M, mode="nearest")
    return rounded


def driven_line(path: Path, aside_m: Array) -> Array:
    """Return the line (n, 4) at an offset from a path: x, y, heading and curvature at its stations."""
    s_m = stations_m(path)
    base = path.poses(s_m)
    slope, scale = np.gradient(aside_m, STEP_M), 1 - path.curvature_pm(s_m) * aside_m
    heading = np.unwrap(base[:, 2] + np.arctan2(slope, scale))
    x, y = base[:, 0] - aside_m * np.sin(base[:, 2]), base[:, 1] + aside_m * np.cos(base[:, 2])
    curvature = np.gradient(heading, STEP_M) / np.hypot(np.gradient(x, STEP_M), np.gradient(y, STEP_M))
    return np.stack([x, y, heading, curvature], axis=1)


def speeds_mps(
    line: Array, start_m: float, end_m: float, *, cruise_mps: float, lateral_mps2: float, braking_mps2: float
) -> Array:
    """Return the speeds (n,) along a line: at most `cruise_mps`, slow in bends, rest at `start_m` and `end_m`."""
    s_m = np.arange(len(line)) * STEP_M
    bends = np.sqrt(lateral_mps2 / np.maximum(np.abs(line[:, 3]), 1e-6))
    speed = np.minimum(cruise_mps, bends)
    first = int(start_m / STEP_M)
    speed[first] = 0.0
    speed[s_m > end_m - STEP_M] = 0.0
    for k in range(len(speed) - 2, first, -1):
        speed[k] = min(speed[k], np.sqrt(speed[k + 1] ** 2 + 2 * braking_mps2 * STEP_M))
    for k in range(first + 1, len(speed)):
        speed[k] = min(speed[k], np.sqrt(speed[k - 1] ** 2 + 2 * braking_mps2 * STEP_M))
    return speed
