"""Half laps past drawn boxes, tunnels and road-works, by the true pose and the laser, judged by the referee."""

from collections import deque

import msgspec
import numpy as np
import pytest
from laser_hall import LASER, Hall, moved, thing

from adc_bench.evaluate.course_progress import Moment
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.log import Header, RunId
from adc_bench.evaluate.programme import Programme
from adc_bench.evaluate.referee import Referee
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.submission import SubmissionId
from adc_bench.evaluate.suite import load_suite, mission_for, rules_id, scenario_for, start_step
from adc_bench.geometry import Path, Pose2, line
from adc_bench.sim import Simulation
from adc_bench.stack.detour import DetourParams, DetourPilot, way_ahead
from adc_bench.stack.obstacle_map import ObstacleMap, see
from adc_bench.stack.prediction import at_rest, send, when_acting
from adc_bench.world.course import Course
from adc_bench.world.robot import Motion
from adc_bench.world.route import half_lap

COURSE = Course(spec=RULES.course)
PERIOD_S = RULES.control_period_s
LEAD_M, BEYOND_M = 10.0, 3.0
PROOF = 50


def route_of(programme: Programme) -> Path:
    """Return the right-hand lane through the ordered half laps, with straights before and behind."""
    pieces = [piece for half in programme.half_laps for piece in half_lap(COURSE, half.loop, half.way)]
    start = Pose2(x_m=-LEAD_M, y_m=-COURSE.spec.lane_outer_radius_m, yaw_rad=0.0)
    return Path(start=start, pieces=(line(LEAD_M), *pieces, line(BEYOND_M)))


def drive(suite_name: str, seed: int) -> tuple[Reason | None, list[str], float]:
    """Drive the trial's first two half laps; return the ending, everything that was hit or done wrong, and the share
    of the half laps driven as ordered.
    """
    suite = msgspec.structs.replace(load_suite(suite_name), seeds=(seed,))
    task, scenario = mission_for(suite, latency_s=0.0, options={}), scenario_for(suite, seed)
    ways = [sign for sign in suite.trial(seed).orders if sign in ("up", "left", "right")][:2]
    header = Header(
        run=RunId(
            suite=msgspec.structs.replace(suite, parking=None),
            rules=rules_id(suite),
            submission=SubmissionId(
                name="test", authors=("someone",), kind="driver", sha256="0" * 64, latency_s=0.0, options={}
            ),
            software={"adc_bench": "0"},
        ),
        scenario=scenario.name,
        seed=seed,
        look=scenario.look,
        start_pose=task.start_pose,
        start_step=start_step(suite, seed),
        orders=(*ways, "end"),
        layout=scenario.layout,
        signs=scenario.signs,
        wheel_separation_m=scenario.robot_truth.wheel_separation_m,
    )
    referee = Referee(course=COURSE, rules=RULES, header=header)
    route, laser = route_of(referee.programme), task.rig.laser
    assert laser is not None
    pilot = DetourPilot(mission=task, laser=laser, route=route, end_m=route.length_m)
    state, under_way = pilot.start(LEAD_M + task.start_pose.x_m), at_rest(PERIOD_S, 0.0)
    world, watch = Simulation(scenario, task.start_pose, PERIOD_S), referee.begin(task.start_pose)
    queue, wrong = deque([(0.0, 0.0)]), []
    while referee.end(watch) is None:
        command, pose, scan = (0.0, 0.0), world.state().pose_world_robot, world.read_sensors().laser
        if world.time_s >= referee.start_s:
            there, motion = when_acting(under_way, task.robot, pose, PERIOD_S)
            state = pilot.look(state, scan, pose, motion) if scan is not None else state
            state, wanted = pilot.steer(state, there, motion)
            under_way, command = send(under_way, task.robot, wanted, PERIOD_S), (wanted.v_mps, wanted.omega_radps)
        world.advance(*queue.popleft())
        queue.append(command)
        wrong += [contact.with_name for contact in world.take_contacts()]
        watch = referee.step(watch, Moment(time_s=world.time_s, pose=world.state().pose_world_robot))
    return referee.end(watch), [*wrong, *(fault.kind.value for fault in watch.faults)], referee.completion(watch)


@pytest.mark.parametrize(("suite_name", "seed"), [("d3", 7403), ("d4", 7504)])
def test_half_laps_past_what_is_drawn(suite_name: str, seed: int) -> None:
    reason, wrong, share = drive(suite_name, seed)
    assert reason is Reason.FINISHED and not wrong and share == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("suite_name", "first", "share"), [("d3", 7401, 0.98), ("d4", 7501, 0.95)])
def test_fifty_drawn_layouts_without_a_touch(suite_name: str, first: int, share: float) -> None:
    runs = [drive(suite_name, seed) for seed in range(first, first + PROOF)]
    clean = [reason is Reason.FINISHED and not wrong for reason, wrong, _ in runs]
    assert np.mean(clean) >= share, [run for run, good in zip(runs, clean, strict=True) if not good]


def boxes_at(*places: tuple[float, float]) -> ObstacleMap:
    """Return a map of boxes at (x, y) on the start straight, met often enough to be believed."""
    across = np.linspace(-0.29, 0.29, 25)
    face = np.concatenate([np.column_stack([np.full(25, -0.29), across]), np.column_stack([across, np.full(25, 0.29)])])
    points = np.concatenate([face + place for place in places])
    known, origin = ObstacleMap(), Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    for step in range(4):
        known = see(known, points, origin, 0.1 * step, DetourParams().map)
    return known


def way_past(*places: tuple[float, float]) -> tuple[np.ndarray, float | None]:
    """Return where the way leads on the start straight (n, 2), and where it stops."""
    task = mission_for(load_suite("d3"), latency_s=0.0, options={})
    way = way_ahead(task, COURSE.lap, boxes_at(*places), 1.0, 40.0, DetourParams())
    points = np.column_stack([way.line.x_m, way.line.y_m])
    return points[points[:, 0] < COURSE.spec.loop_centre_x_m], way.stop_m


def test_the_way_keeps_clear_of_a_box_and_comes_back() -> None:
    points, stop = way_past((2.9, -2.6125))
    assert stop is None
    assert np.hypot(*(points - (2.9, -2.6125)).T).min() > 0.3 + 0.19 + 0.15
    assert points[-1, 1] == pytest.approx(-2.6125, abs=0.02)


def test_the_way_stops_where_both_lanes_are_taken() -> None:
    _, stop = way_past((3.5, -2.6125), (3.6, -1.8375))
    assert stop is not None and stop < 3.2 - 0.46 / 2


def test_a_box_in_the_other_lane_is_in_no_one_s_way() -> None:
    points, stop = way_past((3.0, -1.8375))
    assert stop is None and np.abs(points[:, 1] + 2.6125).max() < 0.02


def test_before_a_closed_road_the_pilot_comes_to_rest_and_stays() -> None:
    task = mission_for(load_suite("d3"), latency_s=0.0, options={})
    hall = Hall([thing(5.0, -2.6125, 0.6, 0.6), thing(5.1, -1.8375, 0.6, 0.6)])
    pilot = DetourPilot(mission=task, laser=LASER, route=COURSE.lap, end_m=40.0)
    state, pose, motion = pilot.start(1.0), COURSE.lap.pose(1.0), Motion()
    for step in range(160):
        if step % 2 == 0:
            state = pilot.look(state, hall.scan(pose, PERIOD_S * step), pose, motion)
        state, motion = pilot.steer(state, pose, motion)
        pose = moved(pose, motion, PERIOD_S)
        assert hall.clearance_m(pose) > 0.05
    assert motion.v_mps < 0.01 and 3.0 < pose.x_m < 4.47
