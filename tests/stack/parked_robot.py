"""A robot of the parking suites that parks by its true pose, or what a test makes of it, and what the referee saw."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from driven_robot import PERIOD_S, Told, truth

from adc_bench.api import Mission
from adc_bench.evaluate.course_progress import Moment
from adc_bench.evaluate.log import Header
from adc_bench.evaluate.referee import Referee
from adc_bench.evaluate.referee_watch import Watch
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.submission import SubmissionId
from adc_bench.evaluate.suite import Suite, load_suite, mission_for, rules_id, scenario_for
from adc_bench.geometry import Pose2
from adc_bench.sim import Simulation
from adc_bench.stack.parking import ParkingPilot
from adc_bench.stack.prediction import at_rest, send, when_acting
from adc_bench.world.course import Course
from adc_bench.world.layout import Layout

COURSE = Course(spec=RULES.course)
LONGEST_S = 40.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Parked:
    """What parking left behind: true poses (n, 3) by control step, the referee's last watch, and what was touched."""

    layout: Layout
    poses: np.ndarray
    watch: Watch
    touched: tuple[str, ...]
    at_rest_s: float

    @property
    def is_clean(self) -> bool:
        """Whether it is parked without a fault or a touch."""
        return self.watch.parked_s is not None and not self.touched and not self.watch.faults


def suite_of(name: str, first_seed: int, count: int) -> Suite:
    """Return a suite with other seeds; its layouts are drawn where it has drawn ones."""
    suite = load_suite(name)
    return msgspec.structs.replace(suite, seeds=tuple(range(first_seed, first_seed + count)))


def parking_pilot(mission: Mission) -> ParkingPilot:
    """Return the pilot of the mission's kind of parking."""
    assert mission.parking
    return ParkingPilot(mission=mission, kind=mission.parking)


def park(suite: Suite, seed: int, told: Told = truth, make: Callable[[Mission], Any] = parking_pilot) -> Parked:
    """Park in a seed's arena, called to at once, and stand until the referee ends it."""
    scenario = scenario_for(suite, seed)
    mission = mission_for(suite, latency_s=0.0, options={})
    world = Simulation(scenario, mission.start_pose, PERIOD_S)
    pilot = make(mission)
    referee = _referee(suite, seed)
    state, under_way, queue = pilot.start(), at_rest(PERIOD_S, 0.0), deque([(0.0, 0.0)])
    pose, rows, touched = world.state().pose_world_robot, [], []
    watch = referee.begin(pose)
    while not referee.end(watch) and world.time_s < LONGEST_S:
        believed, scan = told(len(rows), pose), world.read_sensors().laser
        state = pilot.see(state, believed, scan) if scan else state
        there, motion = when_acting(under_way, mission.robot, believed, PERIOD_S)
        state, command = pilot.steer(state, there, motion)
        under_way = send(under_way, mission.robot, command, PERIOD_S)
        world.advance(*queue.popleft())
        queue.append((command.v_mps, command.omega_radps))
        pose = world.state().pose_world_robot
        rows.append((pose.x_m, pose.y_m, pose.yaw_rad))
        touched += [contact.with_name for contact in world.take_contacts()]
        watch = referee.step(watch, Moment(time_s=world.time_s, pose=pose))
    return Parked(
        layout=scenario.layout, poses=np.array(rows), watch=watch, touched=tuple(touched), at_rest_s=watch.moved_s
    )


def _referee(suite: Suite, seed: int) -> Referee:
    scenario = scenario_for(suite, seed)
    submission = SubmissionId(
        name="made", authors=("someone",), kind="driver", sha256="0" * 64, latency_s=0.0, options={}
    )
    run = RunId(suite=suite, rules=rules_id(suite), submission=submission, software={"adc_bench": "0"})
    header = Header(
        run=run,
        scenario=scenario.name,
        seed=seed,
        look=scenario.look,
        start_pose=Pose2(x_m=suite.start_x_m, y_m=-RULES.course.lane_outer_radius_m, yaw_rad=0.0),
        start_step=0,
        orders=suite.trial(seed).orders,
        layout=scenario.layout,
        signs=scenario.signs,
        wheel_separation_m=scenario.robot_truth.wheel_separation_m,
    )
    return Referee(course=COURSE, rules=RULES, header=header)
