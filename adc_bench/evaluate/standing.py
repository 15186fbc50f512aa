"""A robot that stands: whether it does, where before the stop line, and whether it is parked."""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import shapely

from adc_bench.evaluate.course_progress import Moment, Progress
from adc_bench.evaluate.rules import Rules
from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.world.robot import RobotParams

CORNERS = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])


def is_still(before: Moment, now: Moment, rules: Rules) -> bool:
    """Return whether the robot stood still from one moment to the next."""
    period_s = now.time_s - before.time_s
    moved_m = math.hypot(now.pose.x_m - before.pose.x_m, now.pose.y_m - before.pose.y_m)
    turned_rad = abs(wrap_rad(now.pose.yaw_rad - before.pose.yaw_rad))
    return moved_m <= rules.still_mps * period_s and turned_rad <= rules.still_radps * period_s


def stop_place(progress: Progress, rules: Rules) -> Literal["zone", "near", "far"]:
    """Return where a robot stands before the crosswalk ahead: in the stop zone, near it or over the line, or far away.

    The zone lies in the right-hand lane: the robot's nose at most `stop_zone_m` before the stop line and not over it,
    the middle of its axle in the lane.
    """
    course, robot = rules.course, rules.robot
    line_m = progress.route.length_m - course.crosswalk_depth_m / 2
    room_m = line_m - (progress.s_m + robot.length_m / 2)
    lane_half_m = (course.radius_outer_m - course.radius_centre_m) / 2
    if 0.0 <= room_m <= rules.stop_zone_m and abs(progress.offset_m) <= lane_half_m:
        return "zone"
    return "near" if room_m <= rules.stop_near_m else "far"


def is_inside(pose: Pose2, robot: RobotParams, places: Sequence[shapely.Geometry]) -> bool:
    """Return whether the whole robot, seen from above, lies in one of the places."""
    outline = shapely.Polygon(pose.transform(CORNERS * (robot.length_m / 2, robot.width_m / 2)))
    return any(shapely.contains(place, outline) for place in places)
