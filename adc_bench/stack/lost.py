"""Finding a robot's place again that pictures contradict: guesses about where it may be instead, the nearest first."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.pose_filter import YAW, Estimate


@dataclass(frozen=True, kw_only=True)
class LostParams:
    """When the place counts as lost, and where the robot is looked for then.

    Attributes:
        pictures: running that contradict the estimate, and so many are not looked at twice yet.
        doubt_m, doubt_rad: what each of them adds to the doubt, as standard deviations.
        reach_m, reach_rad: how far off guesses lie at the most, along and aside and in yaw ...
        step_m, step_rad: ... and how far from each other.
        batch: guesses tried with each picture.
        least_edges, least_share: of the expected edges must agree with a guess.
    """

    pictures: int = 5
    doubt_m: float = 0.02
    doubt_rad: float = math.radians(0.5)
    reach_m: float = 0.4
    reach_rad: float = math.radians(12.0)
    step_m: float = 0.1
    step_rad: float = math.radians(4.0)
    batch: int = 12
    least_edges: int = 30
    least_share: float = 0.8


def next_guesses(contradicted: int, params: LostParams) -> tuple[Pose2, ...]:
    """Return the guesses to try, seen from the believed pose, after so many pictures running that contradict it."""
    every = _guesses(params)
    first = (contradicted - params.pictures) * params.batch
    return tuple(every[(first + k) % len(every)] for k in range(params.batch)) if first >= 0 else ()


@lru_cache(maxsize=4)
def _guesses(params: LostParams) -> tuple[Pose2, ...]:
    """Return all guesses, those that take the least of the reach first."""
    metres = _steps(params.reach_m, params.step_m)
    turns = _steps(params.reach_rad, params.step_rad)
    every = [Pose2(x_m=x, y_m=y, yaw_rad=yaw) for x in metres for y in metres for yaw in turns]

    def share(guess: Pose2) -> float:
        return max(math.hypot(guess.x_m, guess.y_m) / params.reach_m, abs(guess.yaw_rad) / params.reach_rad)

    return tuple(sorted(every, key=share))


def _steps(reach: float, step: float) -> tuple[float, ...]:
    count = round(reach / step)
    return tuple(step * k for k in range(-count, count + 1))


def guessed(estimate: Estimate, guess: Pose2) -> Estimate:
    """Return the estimate with its pose as guessed; its doubt stays."""
    pose = estimate.belief.pose @ guess
    mean = np.array([pose.x_m, pose.y_m, pose.yaw_rad, *estimate.mean[YAW + 1 :]])
    mean[YAW] = wrap_rad(float(mean[YAW]))
    return replace(estimate, mean=mean)
