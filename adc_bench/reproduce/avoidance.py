"""Boxes in the lane, gone round by the thesis' rule; between them the PID follows the lap. True pose, laser."""

import math
from collections import deque

import msgspec
import shapely

from adc_bench.evaluate.rules import RULES
from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.reproduce.laps import COURSE, START, mission, simulation_of
from adc_bench.stack.avoidance import AvoidanceParams, Avoiding, avoid
from adc_bench.stack.laser_clusters import clusters
from adc_bench.stack.path_following import progress
from adc_bench.stack.pilots import HeadingPilot, start_s
from adc_bench.stack.prediction import at_rest, send, when_acting
from adc_bench.world.drawing import box_floor
from adc_bench.world.layout import BoxPlace, Layout

AHEAD_M = 1.0  # of the robot on the lap: the direction that must be free for the behaviour to end
BEYOND_M, GIVEN_UP_S = 4.0, 60.0


class Avoidance(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A drive past boxes, by control step: time, true pose, whether the behaviour steered, and the outline's distance
    to the nearest box where it first stood. `passed` if the robot came past them all.
    """

    boxes: tuple[BoxPlace, ...]
    time_s: tuple[float, ...]
    truth: tuple[Pose2, ...]
    avoiding: tuple[bool, ...]
    clearance_m: tuple[float, ...]
    contacts: int
    passed: bool


def go_round(boxes_s_m: tuple[float, ...], speed_mps: float, seed: int) -> Avoidance:
    """Return a drive past boxes that stand in the middle of the lane at these arc lengths, on the left of each."""
    boxes = tuple(_box(COURSE.lap.pose(s_m)) for s_m in boxes_s_m)
    simulation, task = simulation_of(seed, Layout(name="boxes", boxes=boxes)), mission()
    pilot = HeadingPilot(mission=task, speed_mps=speed_mps)
    progress_made, under_way = pilot.start(), at_rest(task.control_period_s, task.latency_s)
    avoiding, around, coming = Avoiding(side="left"), None, deque([(0.0, 0.0)])
    floor = shapely.union_all([box_floor(box) for box in boxes])
    s_m, end_m, contacts = start_s(COURSE.lap, START), boxes_s_m[-1] + BEYOND_M, 0
    rows: list[tuple[float, Pose2, bool, float]] = []
    while s_m < end_m and simulation.time_s < GIVEN_UP_S:
        pose, laser = simulation.state().pose_world_robot, simulation.read_sensors().laser
        s_m = progress(s_m, pose, COURSE.lap)
        if laser is not None and task.rig.laser is not None:
            found = clusters(laser, task.rig.laser)
            avoiding, around = avoid(avoiding, found, _bearing(pose, s_m), simulation.time_s, AvoidanceParams())
        rows.append((simulation.time_s, pose, avoiding.active, float(_outline(pose).distance(floor))))
        there, motion = when_acting(under_way, task.robot, pose, task.control_period_s)
        progress_made, along = pilot.steer(progress_made, there, motion)
        command = around or along
        under_way = send(under_way, task.robot, command, task.control_period_s)
        simulation.advance(*coming.popleft())
        coming.append((command.v_mps, command.omega_radps))
        contacts += len(simulation.take_contacts())
    time_s, truth, active, clearance_m = zip(*rows, strict=True)
    return Avoidance(
        boxes=boxes,
        time_s=time_s,
        truth=truth,
        avoiding=active,
        clearance_m=clearance_m,
        contacts=contacts,
        passed=s_m >= end_m,
    )


def _box(pose: Pose2) -> BoxPlace:
    return BoxPlace(x_m=pose.x_m, y_m=pose.y_m, yaw_rad=pose.yaw_rad)


def _bearing(pose: Pose2, s_m: float) -> float:
    """Return the direction of the lap ahead, seen from the robot."""
    ahead = COURSE.lap.pose(s_m + AHEAD_M)
    return wrap_rad(math.atan2(ahead.y_m - pose.y_m, ahead.x_m - pose.x_m) - pose.yaw_rad)


def _outline(pose: Pose2) -> shapely.Polygon:
    x_m, y_m = RULES.robot.length_m / 2, RULES.robot.width_m / 2
    return shapely.Polygon(pose.transform([(x_m, y_m), (-x_m, y_m), (-x_m, -y_m), (x_m, -y_m)]))
