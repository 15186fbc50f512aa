"""A pilot at the wheel of the simulated robot, told its true pose or what a test makes of it."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import astuple

from adc_bench.api import Mission
from adc_bench.geometry import Pose2
from adc_bench.sim import Simulation
from adc_bench.stack.path_following import progress
from adc_bench.stack.pilots import Pilot
from adc_bench.stack.prediction import at_rest, send, when_acting
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import RobotParams, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.streams import stream

PERIOD_S = 0.05
START = Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)
COURSE = Course()
FAMILY = LookFamily(floors=("felt",), walls=("plaster",), light_sets=("warm_hall",))
Told = Callable[[int, Pose2], Pose2]


@dataclass(frozen=True, kw_only=True, eq=False)
class Driven:
    """What a drive left behind, by control step: time, true poses (n, 3), arc length and offset, commands (n, 2)."""

    time_s: np.ndarray
    poses: np.ndarray
    s_m: np.ndarray
    offset_m: np.ndarray
    commands: np.ndarray

    def crossed_s(self, s_m: float) -> float:
        """Return when an arc length was reached; nan if it was not."""
        after = int(np.argmax(self.s_m >= s_m))
        if self.s_m[after] < s_m:
            return math.nan
        return float(np.interp(s_m, self.s_m[after - 1 : after + 1], self.time_s[after - 1 : after + 1]))


def mission(laps: int = 2, robot: RobotParams | None = None, latency_s: float = 0.0) -> Mission:
    """Return the mission of a drive of so many laps."""
    return Mission(
        name="test",
        laps=laps,
        time_limit_s=200.0,
        control_period_s=PERIOD_S,
        latency_s=latency_s,
        start_pose=START,
        course=CourseSpec(),
        robot=robot or RobotParams(),
        rig=SensorRig(),
        options={},
    )


def simulation(seed: int, robot: RobotParams | None = None) -> Simulation:
    """Return the robot of a seed at the start of an empty course."""
    robot = robot or RobotParams()
    scenario = Scenario(
        name="test",
        seed=seed,
        look=draw_look(FAMILY, stream(seed, "look")),
        robot_truth=draw_robot_truth(robot, stream(seed, "robot")),
        panel_sign="up",
        robot=robot,
        rig=msgspec.structs.replace(SensorRig(), laser=None),
    )
    return Simulation(scenario, START, PERIOD_S)


def truth(step: int, pose: Pose2) -> Pose2:
    """Tell the pose as it is."""
    return pose


def noisy(seed: int, position_m: float, yaw_rad: float) -> Told:
    """Return a teller of poses with white noise."""
    rng = np.random.default_rng(seed)

    def told(step: int, pose: Pose2) -> Pose2:
        x_m, y_m, yaw = rng.standard_normal(3) * (position_m, position_m, yaw_rad)
        return Pose2(x_m=pose.x_m + x_m, y_m=pose.y_m + y_m, yaw_rad=pose.yaw_rad + yaw)

    return told


def drive(
    pilot: Pilot[Any], task: Mission, world: Simulation, seconds: float, told: Told = truth, late_steps: int = 1
) -> Driven:
    """Drive for some time; a command acts `late_steps` after the pose that it answers."""
    state, under_way = pilot.start(), at_rest(PERIOD_S, task.latency_s)
    queue, rows, s_m = deque([(0.0, 0.0)] * late_steps), [], -0.65
    for step in range(round(seconds / PERIOD_S)):
        pose = world.state().pose_world_robot
        s_m = progress(s_m, pose, COURSE.lap)
        _, offset = COURSE.lap.project([(pose.x_m, pose.y_m)], around_s_m=s_m % COURSE.lap.length_m)
        there, motion = when_acting(under_way, task.robot, told(step, pose), PERIOD_S)
        state, command = pilot.steer(state, there, motion)
        under_way = send(under_way, task.robot, command, PERIOD_S)
        rows.append((world.time_s, *astuple(pose), s_m, offset[0], *astuple(command)))
        world.advance(*queue.popleft())
        queue.append((command.v_mps, command.omega_radps))
    table = np.array(rows)
    return Driven(time_s=table[:, 0], poses=table[:, 1:4], s_m=table[:, 4], offset_m=table[:, 5], commands=table[:, 6:])
