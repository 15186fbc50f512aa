"""Where the two driven wheels touch the floor, and what lies under them."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.evaluate.ground import Ground
from adc_bench.geometry import Pose2, wrap_rad

SPACING_M = 0.02  # between the poses looked at within a step: less than a line is wide


@dataclass(frozen=True, kw_only=True)
class Footing:
    """What the wheels met on the way from one pose to the next."""

    on_line: bool  # a contact patch lay on a line that counts
    a_wheel_off: bool  # a wheel's contact point was off the road
    all_off: bool  # at some moment both were


def footing(ground: Ground, before: Pose2, now: Pose2, separation_m: float, wheel_width_m: float) -> Footing:
    """Return what was under the wheels between two poses at most a control step apart.

    A contact patch is the wheel's width across at its contact point, looked at in three points; it lies on a line
    when one of them is within half the line's width of the line's centre. The road ends at its lines' centres.
    """
    patches = patch_points(poses_between(before, now), separation_m, wheel_width_m)
    on_road = ground.is_drivable(patches[:, :, 1].reshape(-1, 2)).reshape(-1, 2)
    moved_m = math.hypot(now.x_m - before.x_m, now.y_m - before.y_m)
    reach_m = moved_m + (separation_m + wheel_width_m) / 2 + ground.touch_m
    # Most steps are far from every line: one distance then stands for all.
    near = bool(ground.distance_to_lines_m([(now.x_m, now.y_m)])[0] <= reach_m)
    on_line = near and bool((ground.distance_to_lines_m(patches.reshape(-1, 2)) <= ground.touch_m).any())
    return Footing(
        on_line=on_line,
        a_wheel_off=bool((~on_road).any()),
        all_off=bool((~on_road).all(axis=1).any()),
    )


def poses_between(before: Pose2, now: Pose2) -> NDArray[np.float64]:
    """Return poses (n, 3) after `before` up to `now`, evenly spaced by at most SPACING_M."""
    distance_m = math.hypot(now.x_m - before.x_m, now.y_m - before.y_m)
    count = max(1, math.ceil(distance_m / SPACING_M))
    shares = np.arange(1, count + 1)[:, None] / count
    step = (now.x_m - before.x_m, now.y_m - before.y_m, wrap_rad(now.yaw_rad - before.yaw_rad))
    poses: NDArray[np.float64] = np.array([before.x_m, before.y_m, before.yaw_rad]) + shares * np.array(step)
    return poses


def patch_points(poses: NDArray[np.float64], separation_m: float, wheel_width_m: float) -> NDArray[np.float64]:
    """Return the points (n, wheel, 3, 2) of both wheels' patches (left, right) in the world, the middle one second."""
    across = np.array([-0.5, 0.0, 0.5]) * wheel_width_m
    left_m = np.array([[separation_m / 2], [-separation_m / 2]]) + across
    leftwards = np.stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2])], axis=1)
    points: NDArray[np.float64] = poses[:, None, None, :2] + left_m[None, :, :, None] * leftwards[:, None, None, :]
    return points
