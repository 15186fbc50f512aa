"""A conduct at the wheel of the simulated robot on an arena of a suite, shown the panels that the referee shows."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from panel_pictures import panel

from adc_bench.evaluate.course_progress import Moment
from adc_bench.evaluate.log import Header
from adc_bench.evaluate.referee import Referee
from adc_bench.evaluate.referee_watch import Watch
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.submission import SubmissionId
from adc_bench.evaluate.suite import Suite, mission_for, rules_id, scenario_for, start_step
from adc_bench.geometry import Pose2
from adc_bench.sim import Simulation
from adc_bench.stack.conduct import Conduct
from adc_bench.stack.orders_pilot import OrdersPilot
from adc_bench.stack.prediction import at_rest, send, when_acting
from adc_bench.world.course import Course

PERIOD_S = RULES.control_period_s
PICTURE_STEPS = 4
COURSE = Course(spec=RULES.course)


@dataclass(frozen=True, kw_only=True, eq=False)
class Ordered:
    """What a drive left behind: the referee with what it saw, poses (n, 3) and commands (n, 2) by control step, and the
    names of what was touched.
    """

    referee: Referee
    watch: Watch
    poses: np.ndarray
    commands: np.ndarray
    touched: tuple[str, ...]


def obey(
    suite: Suite,
    seed: int,
    *,
    read_from_m: float = 2.5,
    speed_mps: float = 2.2,
    make: Callable[..., Conduct[Any]] = OrdersPilot,
) -> Ordered:
    """Drive a run to its end; the panel is seen from so far before it, by a robot that looks towards it. Where nothing
    can stand in the way there is no laser.
    """
    referee, scenario = _referee(suite, seed), scenario_for(suite, seed)
    mission = mission_for(suite, latency_s=0.0, options={})
    laser = scenario.rig.laser if {"boxes", "works"} & set(mission.elements) else None
    world = Simulation(
        msgspec.structs.replace(scenario, rig=msgspec.structs.replace(scenario.rig, laser=laser)),
        mission.start_pose,
        PERIOD_S,
    )
    pilot = make(mission=mission, speed_mps=speed_mps)
    state, under_way = pilot.start(), at_rest(PERIOD_S, mission.latency_s)
    queue, rows, touched = deque([(0.0, 0.0)]), [], []
    pose = world.state().pose_world_robot
    watch = referee.begin(pose)
    while not referee.end(watch):
        if len(rows) % PICTURE_STEPS == 0 and pilot.looks(state):
            sign = referee.panels(watch) if sees_panel(pose, read_from_m) else None
            state = pilot.look(state, pose, panel(sign))
        scan = world.read_sensors().laser
        if scan is not None:
            state = pilot.see(state, pose, scan)
        there, motion = when_acting(under_way, mission.robot, pose, PERIOD_S)
        state, command = pilot.steer(state, there, motion)
        under_way = send(under_way, mission.robot, command, PERIOD_S)
        world.advance(*queue.popleft())
        queue.append((command.v_mps, command.omega_radps))
        touched += [contact.with_name for contact in world.take_contacts()]
        pose = world.state().pose_world_robot
        rows.append((pose.x_m, pose.y_m, pose.yaw_rad, command.v_mps, command.omega_radps))
        watch = referee.step(watch, Moment(time_s=world.time_s, pose=pose))
    table = np.array(rows)
    return Ordered(
        referee=referee, watch=watch, poses=table[:, :3], commands=table[:, 3:], touched=tuple(sorted(set(touched)))
    )


def sees_panel(pose: Pose2, read_from_m: float) -> bool:
    """Return whether the panel of the lane is within a camera's 90 degrees and near enough."""
    c = COURSE.spec
    y_m = -c.lane_outer_radius_m if np.cos(pose.yaw_rad) > 0 else -c.lane_inner_radius_m
    ((ahead_m, left_m),) = pose.inverse().transform([(0.0, y_m)])
    return bool(0.0 < ahead_m < read_from_m and abs(left_m) < ahead_m)


def _referee(suite: Suite, seed: int) -> Referee:
    scenario = scenario_for(suite, seed)
    submission = SubmissionId(
        name="made", authors=("someone",), kind="driver", sha256="0" * 64, latency_s=0.0, options={}
    )
    header = Header(
        run=RunId(suite=suite, rules=rules_id(suite), submission=submission, software={"adc_bench": "0"}),
        scenario=scenario.name,
        seed=seed,
        look=scenario.look,
        start_pose=mission_for(suite, latency_s=0.0, options={}).start_pose,
        start_step=start_step(suite, seed),
        orders=suite.trial(seed).orders,
        layout=scenario.layout,
        signs=scenario.signs,
        wheel_separation_m=scenario.robot_truth.wheel_separation_m,
    )
    return Referee(course=COURSE, rules=RULES, header=header)
