"""Errors of an estimated trajectory as SLAM measures them, ATE and RPE, and whether its covariances can be believed.

Poses are rows (x_m, y_m, yaw_rad); truth and estimate are of the same times.
"""

import math
from collections.abc import Sequence
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from adc_bench.geometry import wrap_array_rad

Array = NDArray[np.float64]
STATE_SIZE = 3  # x, y, yaw
LEVEL = 0.95


class NeesVerdict(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The mean NEES of n runs between the bounds of a chi-square test at 95 %.

    Above `high` the filter believes itself better than it is, below `low` worse.
    """

    mean: float
    low: float
    high: float
    n: int
    verdict: Literal["consistent", "overconfident", "overcautious"]


def aligned(truth: Array, estimate: Array) -> Array:
    """Return the estimates (n, 3) after the rotation and shift that bring them nearest to the truth (n, 3).

    Nearest in the sum of squared distances (Umeyama 1991, without scale), in the plane.
    """
    centre_truth, centre_estimate = truth[:, :2].mean(axis=0), estimate[:, :2].mean(axis=0)
    there, here = truth[:, :2] - centre_truth, estimate[:, :2] - centre_estimate
    across = np.sum(here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0])
    turn_rad = math.atan2(across, np.sum(here * there))
    cos, sin = math.cos(turn_rad), math.sin(turn_rad)
    moved = here @ np.array([[cos, sin], [-sin, cos]]) + centre_truth
    return np.column_stack([moved, wrap_array_rad(estimate[:, 2] + turn_rad)])


def relative_errors(truth: Array, estimate: Array, steps: int) -> tuple[Array, Array]:
    """Return how far the estimated motion over `steps` is from the true one: distances [m] and angles [rad].

    Both are (n - steps,), empty if there are not that many. E = (T_i^-1 T_j)^-1 (P_i^-1 P_j) with j = i + steps
    (Sturm et al. 2012).
    """
    true_motion = _motion(truth[:-steps], truth[steps:])
    motion = _motion(estimate[:-steps], estimate[steps:])
    error = _motion(true_motion, motion)
    return np.hypot(error[:, 0], error[:, 1]), np.abs(error[:, 2])


def _motion(start: Array, end: Array) -> Array:
    """Return the poses `end` as seen from the poses `start`, both (n, 3)."""
    dx, dy = (end[:, :2] - start[:, :2]).T
    cos, sin = np.cos(start[:, 2]), np.sin(start[:, 2])
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx, wrap_array_rad(end[:, 2] - start[:, 2])], axis=1)


def nees_verdict(run_means: Sequence[float]) -> NeesVerdict:
    """Return the verdict on the mean NEES of each of n >= 1 independent runs.

    The errors within a run hang together, so that a run counts as a single draw however long it is: n times the mean
    is held against chi-square with 3 n degrees of freedom (Bar-Shalom et al. 2001, section 5.4.2).
    """
    n = len(run_means)
    low, high = chi2.ppf(((1 - LEVEL) / 2, (1 + LEVEL) / 2), STATE_SIZE * n) / n
    mean = math.fsum(run_means) / n
    verdict: Literal["consistent", "overconfident", "overcautious"]
    verdict = "overconfident" if mean > high else "overcautious" if mean < low else "consistent"
    return NeesVerdict(mean=mean, low=float(low), high=float(high), n=n, verdict=verdict)
