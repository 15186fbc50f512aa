"""Passing boxes by the other lane: which stretches of either lane are taken, and how far to move over where.

Offsets are from the middle of the driven lane, left positive; `pitch_m` is that of the other lane's middle.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ChangeParams:
    """How a change is driven and what counts as taking a lane. A robot in a lane's middle reaches 0.19 m aside."""

    change_m: float = 2.0  # along the lane, for one change
    before_m: float = 0.10  # before and behind a box the change is complete
    nose_m: float = 0.35  # from the robot's origin to its front or tail, and a margin
    lane_half_m: float = 0.25  # what stands nearer to a lane's middle takes the lane
    box_length_m: float = 0.60  # what the robot does not see behind a box's front
    join_m: float = 0.5
    stop_before_m: float = 0.75  # from the robot's origin to what stands in both lanes


@dataclass(frozen=True, kw_only=True)
class Taken:
    """A stretch of a lane on which something stands."""

    from_m: float
    to_m: float


def taken(s_m: Array, offset_m: Array, lane_m: float, params: ChangeParams) -> tuple[Taken, ...]:
    """Return the stretches taken of the lane at the offset `lane_m` by points at (s, offset), each (n,), in order."""
    here = np.sort(s_m[np.abs(offset_m - lane_m) < params.lane_half_m])
    if not len(here):
        return ()
    parts = np.split(here, np.flatnonzero(np.diff(here) > params.join_m) + 1)
    return tuple(
        Taken(from_m=float(part[0]), to_m=float(max(part[-1], part[0] + params.box_length_m))) for part in parts
    )


def offsets(s_m: Array, right: tuple[Taken, ...], pitch_m: float, params: ChangeParams) -> Array:
    """Return how far left (n,) to be at arc lengths (n,): in the other lane beside all that stands in the own one.

    The change's path has no jump in its curvature.
    """
    share = np.zeros_like(s_m)
    for box in right:
        into = (s_m - (box.from_m - params.before_m - params.change_m)) / params.change_m
        back = (box.to_m + params.before_m + params.change_m - s_m) / params.change_m
        share = np.maximum(share, _smooth(np.minimum(into, back)))
    return pitch_m * share


def stop_m(right: tuple[Taken, ...], left: tuple[Taken, ...], params: ChangeParams) -> float | None:
    """Return where to stop because both lanes are taken: before the first box that cannot be passed, or None."""
    for box in right:
        low, high = box.from_m - params.nose_m, box.to_m + params.nose_m
        if any(other.from_m - params.nose_m < high and low < other.to_m + params.nose_m for other in left):
            return box.from_m - params.stop_before_m
    return None


def _smooth(share: Array) -> Array:
    """Return the step from 0 to 1 whose first and second derivatives are zero at both ends."""
    t = np.clip(share, 0.0, 1.0)
    step: Array = t * t * t * (10 - 15 * t + 6 * t * t)
    return step
