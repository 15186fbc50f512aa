"""The way through road-works, from the cones that the laser has met.

The corridor's middle is a smooth curve beside the lane: a Gaussian process of the offset m(s), zero in the mean, so
that the way leaves the lane where the cones lead off it and comes back where they end. A cone of the outer row lies
about half a corridor to the right of the middle, one of the inner row to the left; which row each cone
belongs to is what the process finds most likely among all ways to tell them apart. Where the robot is, the corridor is.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class WorksParams:
    """The corridor as published (0.89 to 1.11 m between the rows), and how its middle may run.

    The way keeps farther from the outer row's cones: the tape between them cuts the bend.
    """

    outer_m: float = 0.59
    inner_m: float = 0.44
    swing_m: float = 0.6  # standard deviation of the middle's offset
    bend_m: float = 1.4  # over which it changes
    noise_m: float = 0.06
    here_m: float = 0.12  # how far the robot may be from the middle, one sd
    outlier: float = 8.0  # what a cone must spoil to be left out; those of drawn road-works spoil 7 at most
    mouth_m: float = 0.75  # one cone at least stands nearer to the lane's middle
    link_m: float = 2.0  # between neighbours of a row
    across_m: float = 1.3  # from a row's cone to one of the other row that comes before it ...
    back_m: float = 0.5  # ... along the lane: rows begin in the lane, so that what stands out there comes later
    cones_max: int = 10
    slope_max: float = 1.0
    rounds: int = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class Corridor:
    """The middle's offset as a process: stations (n + 1,) of the cones and of the robot, and their weights (n + 1,)."""

    s_m: Array
    weights: Array
    cost: float
    params: WorksParams

    def offsets(self, s_m: Array) -> Array:
        """Return the middle's offset (k,) at arc lengths (k,), left positive."""
        offset: Array = _kernel(s_m, self.s_m, self.params) @ self.weights
        return offset

    def slopes(self, s_m: Array) -> Array:
        """Return how fast the offset changes, (k,), at arc lengths (k,)."""
        apart = s_m[:, None] - self.s_m[None, :]
        slope: Array = (-apart / self.params.bend_m**2 * _kernel(s_m, self.s_m, self.params)) @ self.weights
        return slope


def works_cones(s_m: Array, offset_m: Array, params: WorksParams) -> NDArray[np.intp]:
    """Return which of the cones at (s, offset), each (n,), are the road-works', by arc length: those that stand near
    the lane's middle, and from them on those linked to one.
    """
    found = np.abs(offset_m) < params.mouth_m
    apart = np.hypot(s_m[:, None] - s_m[None, :], offset_m[:, None] - offset_m[None, :])
    later_m = s_m[:, None] - s_m[None, :]
    across = (apart < params.across_m) & (later_m > -params.back_m)
    linked = across | ((apart < params.link_m) & (later_m >= 0))
    for _ in range(len(s_m)):
        found = found | linked[:, found].any(axis=1)
    order = np.argsort(s_m, kind="stable")
    chosen: NDArray[np.intp] = order[found[order]][: params.cones_max]
    return chosen


def corridor(
    s_m: Array, offset_m: Array, curvature_pm: Array, here_m: tuple[float, float], params: WorksParams
) -> Corridor | None:
    """Return the corridor between cones at (s, offset) beside a lane of these curvatures, each (n,); None without any.

    `here_m` is the robot's (s, offset), whether between the cones or on its way to them. A cone that fits none of the
    rows is left out.
    """
    while len(s_m):
        fit = _fit(s_m, offset_m, curvature_pm, here_m, params)
        if len(s_m) == 1:
            return fit
        others = [np.delete(np.arange(len(s_m)), k) for k in range(len(s_m))]
        costs = [_fit(s_m[o], offset_m[o], curvature_pm[o], here_m, params).cost for o in others]
        best = int(np.argmin(costs))
        if fit.cost - costs[best] < params.outlier:
            return fit
        s_m, offset_m, curvature_pm = s_m[others[best]], offset_m[others[best]], curvature_pm[others[best]]
    return None


def _fit(
    s_m: Array, offset_m: Array, curvature_pm: Array, here_m: tuple[float, float], params: WorksParams
) -> Corridor:
    """Return the likeliest corridor. Where the middle runs aslant, the rows are farther off along the normal."""
    stations = np.append(s_m, here_m[0])
    noise_m = np.append(np.full(len(s_m), params.noise_m), params.here_m)
    inverse = np.linalg.inv(_kernel(stations, stations, params) + np.diag(np.square(noise_m)))
    sides = _sides(len(s_m))
    half_m = np.where(sides > 0, params.outer_m, params.inner_m)
    here = np.full((len(sides), 1), here_m[1])
    steeper = np.ones_like(s_m)
    for _ in range(params.rounds):
        middles = np.hstack([offset_m + sides * half_m * steeper, here])
        costs = np.einsum("ki,ij,kj->k", middles, inverse, middles)
        best = int(np.argmin(costs))
        found = Corridor(s_m=stations, weights=inverse @ middles[best], cost=float(costs[best]), params=params)
        slope = np.minimum(np.abs(found.slopes(s_m)) / (1 - curvature_pm * offset_m), params.slope_max)
        steeper = np.asarray(np.hypot(1.0, slope), dtype=np.float64)
    return found


@lru_cache(maxsize=16)
def _sides(count: int) -> Array:
    """Return every way to tell the rows apart, (2^n, n): 1 for a cone of the outer row, -1 for one of the inner."""
    bits = (np.arange(2**count)[:, None] >> np.arange(count)[None, :]) & 1
    return np.asarray(2 * bits - 1, dtype=np.float64)


def _kernel(a_m: Array, b_m: Array, params: WorksParams) -> Array:
    apart = (a_m[:, None] - b_m[None, :]) / params.bend_m
    kernel: Array = params.swing_m**2 * np.exp(-0.5 * apart**2)
    return kernel
