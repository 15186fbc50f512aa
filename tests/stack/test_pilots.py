"""The pilots on the simulated robot, whose wheels differ from their nominal figures."""

import math

import numpy as np
import pytest
from driven_robot import COURSE, START, Driven, drive, mission, noisy, simulation

from adc_bench.evaluate.wheels import patch_points
from adc_bench.geometry import Pose2
from adc_bench.stack.pilots import BEYOND_FINISH_M, HeadingPilot, LinePilot, TrajectoryPilot, timetable_of
from adc_bench.world.robot import RobotParams

FINISH_M = 2 * COURSE.lap.length_m


def line_gap_m(driven: Driven) -> float:
    """Return how near a wheel came to an edge line's paint; negative on it."""
    patches = patch_points(driven.poses, RobotParams().wheel_separation_m, 0.05).reshape(-1, 2)
    return float(COURSE.distance_to_edge_lines_m(patches).min()) - COURSE.spec.edge_line_width_m / 2


@pytest.mark.parametrize("seed", [1, 2])
def test_two_laps_at_the_limit_within_2_cm_of_the_lane(seed: int) -> None:
    task = mission()
    driven = drive(LinePilot(mission=task, speed_mps=2.2), task, simulation(seed), 41.0)
    assert driven.crossed_s(FINISH_M) < 38.1
    assert np.abs(driven.offset_m).max() < 0.02
    assert line_gap_m(driven) > 0.15
    assert driven.s_m[-1] == pytest.approx(timetable_of(task, 2.2).line.path_s_m[-1], abs=0.05)
    assert np.hypot(*(driven.poses[-1] - driven.poses[-10])[:2]) < 1e-3


def test_poses_with_noise_of_2_cm_and_half_a_degree_do_not_throw_it_off() -> None:
    task = mission()
    told = noisy(5, 0.02, math.radians(0.5))
    driven = drive(LinePilot(mission=task, speed_mps=2.2), task, simulation(3), 39.0, told)
    assert driven.crossed_s(FINISH_M) < 38.3
    assert np.abs(driven.offset_m).max() < 0.04


@pytest.mark.parametrize("latency_s", [0.05, 0.15])
def test_a_declared_latency_is_driven_for(latency_s: float) -> None:
    late_steps = 1 + round(latency_s / 0.05)
    for told_s, bound_m in ((latency_s, (0.0, 0.02)), (0.0, (0.03, 1.0))):
        task = mission(laps=1, latency_s=told_s)
        pilot = LinePilot(mission=task, speed_mps=2.2)
        driven = drive(pilot, task, simulation(1), 12.0, late_steps=late_steps)
        assert bound_m[0] < np.abs(driven.offset_m).max() < bound_m[1]


def test_a_pose_that_stays_out_now_and_then_costs_millimetres() -> None:
    seen = [START]

    def stale(step: int, pose: Pose2) -> Pose2:
        seen.append(pose)
        return seen[-2] if step % 20 == 10 else pose

    task = mission(laps=1)
    driven = drive(LinePilot(mission=task, speed_mps=2.2), task, simulation(1), 18.0, stale)
    assert np.abs(driven.offset_m).max() < 0.02


def test_wheels_that_slip_throw_it_off_unless_it_knows_of_the_floor() -> None:
    slippery = RobotParams(friction=0.2)
    offsets_m = []
    for known in (slippery, RobotParams()):
        task = mission(laps=1, robot=known)
        driven = drive(LinePilot(mission=task, speed_mps=2.2), task, simulation(1, slippery), 9.0)
        offsets_m.append(np.abs(driven.offset_m).max())
    assert offsets_m[0] < 0.06 < 0.3 < offsets_m[1]


@pytest.mark.parametrize("speed_mps", [0.5, 1.5])
def test_the_thesis_trajectory_tracking_keeps_its_timetable(speed_mps: float) -> None:
    task = mission(laps=1)
    pilot = TrajectoryPilot(mission=task, speed_mps=speed_mps)
    timetable = timetable_of(task, speed_mps)
    driven = drive(pilot, task, simulation(2), 20.0)
    assert np.abs(driven.offset_m).max() < 0.02
    due_s = float(np.interp(5.0, timetable.line.path_s_m, timetable.time_s))
    assert driven.crossed_s(5.0) == pytest.approx(due_s + 0.05, abs=0.05)


def test_the_thesis_pid_gets_round_at_1_mps_and_stops_behind_the_finish() -> None:
    task = mission(laps=1)
    driven = drive(HeadingPilot(mission=task), task, simulation(2), 44.0)
    assert np.abs(driven.offset_m).max() < 0.05
    assert driven.crossed_s(COURSE.lap.length_m) == pytest.approx(41.1 + 0.8, abs=0.8)
    assert BEYOND_FINISH_M < driven.s_m[-1] - COURSE.lap.length_m < BEYOND_FINISH_M + 0.5
