"""The straight landmark: both lines of a straight lane -> the lane's middle as a direction and a distance."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.robust_fit import Fit, FitNoise, fit_shape

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class StraightParams:
    """When points count as the lines of a straight lane."""

    least_points: int = 6
    least_length_m: float = 0.6
    worst_rms: float = 2.0


def see_straight(
    lines: Mapping[float, Array],
    birds_eye: BirdsEye,
    noise: FitNoise | None = None,
    params: StraightParams | None = None,
) -> Fit | None:
    """Return the lane's middle as parameters [normal angle, distance]: p . n = d in the robot frame, n to the left.

    `lines` maps each line's offset from the middle (left positive, metres) to its points (n, 2). None where the points
    are few, short or not straight.
    """
    p = params or StraightParams()
    points = np.concatenate(list(lines.values()))
    offsets = np.concatenate([np.full(len(part), offset) for offset, part in lines.items()])
    if len(points) < p.least_points or np.ptp(points[:, 0]) < p.least_length_m:
        return None
    start = _start(points, offsets)
    fit = fit_shape(lambda line: _to_line(line, points, offsets), start, points, birds_eye, noise or FitNoise())
    return fit if fit.rms < p.worst_rms else None


def _start(points: Array, offsets: Array) -> Array:
    """Return the ordinary regression of y - offset on x, as [normal angle, distance]."""
    slope, intercept = np.polyfit(points[:, 0], points[:, 1] - offsets, 1)
    direction = math.atan(slope)
    return np.array([direction + math.pi / 2, intercept * math.cos(direction)])


def _to_line(line: Array, points: Array, offsets: Array) -> tuple[Array, Array, Array]:
    """Return residuals p . n - d - offset, their Jacobian in [angle, d], and the normals in p."""
    n = np.array([math.cos(line[0]), math.sin(line[0])])
    along = points @ np.array([-n[1], n[0]])
    jacobian = np.column_stack([along, -np.ones(len(points))])
    return points @ n - line[1] - offsets, jacobian, np.broadcast_to(n, points.shape)
