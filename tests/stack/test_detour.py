"""Drives past drawn boxes, tunnels and road-works, by the true pose and the laser, judged by the referee."""

import msgspec
import numpy as np
import pytest
from laser_hall import Hall, moved, thing
from ordered_robot import COURSE, PERIOD_S, Ordered, obey
from panel_pictures import panel

from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.suite import load_suite, mission_for
from adc_bench.geometry import Pose2
from adc_bench.stack.detour import DetourParams, way_ahead
from adc_bench.stack.obstacle_map import ObstacleMap, see
from adc_bench.stack.orders_pilot import OrdersPilot
from adc_bench.world.robot import Motion

PROOF = 50


def is_perfect(run: Ordered) -> bool:
    """Return whether a drive was finished as ordered, parking included, without a fault and without a touch."""
    finished = run.referee.end(run.watch) is Reason.FINISHED and run.referee.completion(run.watch) == 1.0
    return finished and not run.watch.faults and not run.touched


@pytest.mark.parametrize(("suite_name", "seed"), [("dev-d3", 7403), ("dev-d4", 7504)])
def test_a_lap_past_what_is_drawn(suite_name: str, seed: int) -> None:
    run = obey(msgspec.structs.replace(load_suite(suite_name), seeds=(seed,)), seed)
    assert is_perfect(run), (run.watch, run.touched)


@pytest.mark.slow
@pytest.mark.parametrize(("suite_name", "first", "share"), [("d3", 7401, 0.98), ("d4", 7501, 0.95)])
def test_fifty_drawn_layouts_without_a_touch(suite_name: str, first: int, share: float) -> None:
    suite = msgspec.structs.replace(load_suite(suite_name), seeds=tuple(range(first, first + PROOF)))
    perfect = {seed: is_perfect(obey(suite, seed)) for seed in suite.seeds}
    assert np.mean(list(perfect.values())) >= share, [seed for seed, good in perfect.items() if not good]


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
    way = way_ahead(task, COURSE.lap, boxes_at(*places), (1.0, 0.0), 40.0, DetourParams())
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
    pilot = OrdersPilot(mission=task, speed_mps=2.2)
    state, pose, motion = pilot.start(), task.start_pose, Motion()
    for _ in range(2):
        state = pilot.look(state, pose, panel("up"))
    for step in range(200):
        if step % 2 == 0:
            state = pilot.see(state, pose, hall.scan(pose, PERIOD_S * step))
        state, motion = pilot.steer(state, pose, motion)
        pose = moved(pose, motion, PERIOD_S)
        assert hall.clearance_m(pose) > 0.05
    assert motion.v_mps < 0.01 and 3.0 < pose.x_m < 4.47


def test_what_was_seen_on_one_leg_is_known_on_the_next() -> None:
    task = mission_for(load_suite("d3"), latency_s=0.0, options={})
    hall, pilot = Hall([thing(2.0, -2.6125, 0.6, 0.6)]), OrdersPilot(mission=task, speed_mps=2.2)
    state = pilot.start()
    for step in range(4):
        state = pilot.see(state, task.start_pose, hall.scan(task.start_pose, 0.1 * step))
    for _ in range(2):
        state = pilot.look(state, task.start_pose, panel("up"))
    known = state.known
    state, _ = pilot.steer(state, task.start_pose, Motion())
    assert state.known is known
    assert state.timetable is not None and state.timetable.line.y_m.max() > -2.0
