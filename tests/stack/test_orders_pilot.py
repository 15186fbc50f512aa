"""Trials of D2 on the simulated robot with its true pose, judged by the referee."""

import math

import numpy as np
import pytest
from ordered_robot import COURSE, Ordered, obey

from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.suite import load_suite
from adc_bench.evaluate.wheels import patch_points
from adc_bench.stack.legs import half_lap_leg, stop_before_m
from adc_bench.world.robot import RobotParams

D2 = load_suite("d2")
STOP_SEED = D2.seeds[2]  # of the trial up, right, stop, up, right, end


def assert_perfect(run: Ordered) -> None:
    programme = run.referee.programme
    assert run.referee.end(run.watch) is Reason.FINISHED
    assert run.watch.faults == ()
    assert run.referee.completion(run.watch) == 1.0
    assert run.watch.as_ordered == len(programme.half_laps)
    patches = patch_points(run.poses, RobotParams().wheel_separation_m, 0.05).reshape(-1, 2)
    assert COURSE.distance_to_edge_lines_m(patches).min() > 0.025 + 0.10


def test_a_turn_and_a_stop_without_a_fault() -> None:
    assert_perfect(obey(D2, STOP_SEED))


@pytest.mark.slow
@pytest.mark.parametrize("seed", D2.seeds[:5])
def test_every_trial_of_d2_without_a_fault(seed: int) -> None:
    assert_perfect(obey(D2, seed))


@pytest.mark.slow
def test_signs_that_are_read_late_cost_seconds_only() -> None:
    seed = D2.seeds[0]
    early, late = obey(D2, seed, read_from_m=4.0), obey(D2, seed, read_from_m=1.0)
    for run in (early, late):
        assert_perfect(run)
    assert len(early.poses) < len(late.poses)


def test_without_an_order_it_waits_in_the_stop_zone() -> None:
    run = obey(D2, D2.seeds[0], read_from_m=0.7)  # the start is nearer than that, the stop zone's place is not
    assert run.referee.end(run.watch) is Reason.BLOCKED
    assert run.watch.faults == ()
    assert run.poses[-1][0] == pytest.approx(stop_before_m(COURSE.spec, RobotParams()), abs=0.05)
    assert (run.commands[-100:] == 0).all()


def test_it_parks_from_a_stand_when_it_is_told_to() -> None:
    suite = load_suite("p1")
    run = obey(suite, suite.seeds[0])
    assert run.watch.parked_s is not None
    assert run.watch.faults == ()


def test_the_next_leg_begins_as_the_last_one_ends() -> None:
    stop_m = stop_before_m(COURSE.spec, RobotParams())
    for way in ("straight", "turn"):
        before = half_lap_leg(COURSE.spec, "east", "turn", way, stop_m)
        end_m = float(np.interp(before.end_m, before.line.path_s_m, before.line.s_m))
        end = before.line.pose(end_m - 0.5)
        for onward in ("straight", "turn"):
            after = half_lap_leg(COURSE.spec, "west", way, onward, stop_m).line
            start = after.pose(after.project(end, 5.0, 5.0))
            assert math.hypot(start.x_m - end.x_m, start.y_m - end.y_m) < 1e-3
            assert np.cos(start.yaw_rad - end.yaw_rad) > 1 - 1e-5
