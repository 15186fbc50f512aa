"""A lap by a pilot that is told the true pose: what control alone does, without pictures."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

import msgspec
import numpy as np

from adc_bench.api import Mission
from adc_bench.evaluate.rules import RULES
from adc_bench.geometry import Pose2
from adc_bench.reproduce.settings import Controller
from adc_bench.sim import Simulation
from adc_bench.stack.path_following import progress
from adc_bench.stack.pilots import HeadingPilot, Pilot, TrajectoryPilot, start_s
from adc_bench.stack.prediction import at_rest, send, when_acting
from adc_bench.world.course import Course
from adc_bench.world.layout import Layout
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.streams import stream

COURSE = Course(spec=RULES.course)
START = Pose2(x_m=-0.65, y_m=-RULES.course.lane_outer_radius_m, yaw_rad=0.0)
FAMILY = LookFamily(floors=("felt",), walls=("plaster",), light_sets=("warm_hall",))  # nobody looks
PILOTS: Mapping[Controller, Callable[..., Pilot[Any]]] = {"pid": HeadingPilot, "linearisation": TrajectoryPilot}
GIVEN_UP_SHARE, GIVEN_UP_S = 1.5, 10.0


class Lap(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A drive, by control step: time, true pose, arc length and offset on the lane's middle (left positive), speed;
    and all encoder samples. The lap counts from the crosswalk's middle to there again.
    """

    time_s: tuple[float, ...]
    x_m: tuple[float, ...]
    y_m: tuple[float, ...]
    yaw_rad: tuple[float, ...]
    s_m: tuple[float, ...]
    offset_m: tuple[float, ...]
    v_mps: tuple[float, ...]
    encoder_time_s: tuple[float, ...]
    left_ticks: tuple[int, ...]
    right_ticks: tuple[int, ...]

    def crossed_s(self, s_m: float) -> float | None:
        """Return when an arc length was reached, None if it was not."""
        after = next((k for k, reached in enumerate(self.s_m) if reached >= s_m), None)
        if not after:
            return None
        ends = slice(after - 1, after + 1)
        return float(np.interp(s_m, self.s_m[ends], self.time_s[ends]))

    @property
    def lap_s(self) -> float | None:
        """The lap's time, None if the drive ended before."""
        begun_s, done_s = self.crossed_s(0.0), self.crossed_s(COURSE.lap.length_m)
        return None if begun_s is None or done_s is None else done_s - begun_s


def mission(laps: int = 1) -> Mission:
    """Return the mission of laps on the empty course."""
    return Mission(
        name="laps",
        laps=laps,
        time_limit_s=300.0,
        control_period_s=RULES.control_period_s,
        latency_s=0.0,
        start_pose=START,
        course=RULES.course,
        robot=RULES.robot,
        rig=RULES.rig,
        options={},
    )


def drive_lap(controller: Controller, speed_mps: float, seed: int) -> Lap:
    """Return a lap by the seed's robot; it is given up after one and a half times the time that it should take."""
    task, length_m = mission(), COURSE.lap.length_m
    pilot: Pilot[Any] = PILOTS[controller](mission=task, speed_mps=speed_mps)
    simulation, period_s = simulation_of(seed, Layout()), task.control_period_s
    state, under_way, coming = pilot.start(), at_rest(period_s, task.latency_s), deque([(0.0, 0.0)])
    rows: list[tuple[float, ...]] = []
    samples: list[tuple[float, int, int]] = []
    s_m = start_s(COURSE.lap, START)
    until_s = GIVEN_UP_SHARE * length_m / speed_mps + GIVEN_UP_S
    while s_m < length_m + 0.1 and simulation.time_s < until_s:
        pose, seen = simulation.state(), simulation.read_sensors().encoders
        s_m = progress(s_m, pose.pose_world_robot, COURSE.lap)
        samples += zip(seen.time_s.tolist(), seen.left_ticks.tolist(), seen.right_ticks.tolist(), strict=True)
        rows.append((simulation.time_s, *msgspec.structs.astuple(pose.pose_world_robot), s_m, pose.v_mps))
        there, motion = when_acting(under_way, task.robot, pose.pose_world_robot, period_s)
        state, command = pilot.steer(state, there, motion)
        under_way = send(under_way, task.robot, command, period_s)
        simulation.advance(*coming.popleft())
        coming.append((command.v_mps, command.omega_radps))
    return _lap(np.array(rows), samples)


def simulation_of(seed: int, layout: Layout) -> Simulation:
    """Return the seed's robot at the start of a course with this layout; with a laser if there is a box to meet."""
    scenario = Scenario(
        name="lap",
        seed=seed,
        look=draw_look(FAMILY, stream(seed, "look")),
        robot_truth=draw_robot_truth(RULES.robot, stream(seed, "robot")),
        panel_sign="up",
        layout=layout,
        robot=RULES.robot,
        rig=msgspec.structs.replace(RULES.rig, laser=RULES.rig.laser if layout.boxes else None),
    )
    return Simulation(scenario, START, RULES.control_period_s)


def _lap(table: np.ndarray[Any, np.dtype[np.float64]], samples: list[tuple[float, int, int]]) -> Lap:
    time_s, x_m, y_m, yaw_rad, s_m, v_mps = (tuple(column) for column in table.T.tolist())
    encoder_time_s, left_ticks, right_ticks = zip(*samples, strict=True)
    return Lap(
        time_s=time_s,
        x_m=x_m,
        y_m=y_m,
        yaw_rad=yaw_rad,
        s_m=s_m,
        offset_m=tuple(_offset_m(*place) for place in zip(x_m, y_m, s_m, strict=True)),
        v_mps=v_mps,
        encoder_time_s=encoder_time_s,
        left_ticks=left_ticks,
        right_ticks=right_ticks,
    )


def _offset_m(x_m: float, y_m: float, s_m: float) -> float:
    _, offset = COURSE.lap.project([(x_m, y_m)], around_s_m=math.fmod(s_m, COURSE.lap.length_m))
    return float(offset[0])
