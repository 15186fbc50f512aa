"""The thesis' way of driving with panels and boxes, by the true pose, judged by the referee."""

import numpy as np
import pytest
from laser_hall import LASER, Hall, thing
from ordered_robot import obey
from panel_pictures import panel

from adc_bench.api import Mission
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.suite import load_suite, mission_for
from adc_bench.geometry import Pose2
from adc_bench.stack.thesis_pilot import ThesisPilot, ThesisProgress
from adc_bench.world.robot import Motion

START = Pose2(x_m=0.5, y_m=-2.6125, yaw_rad=0.0)


def test_a_lap_with_a_stop_and_a_turn_without_a_fault() -> None:
    suite = load_suite("dev-d2")
    run = obey(suite, suite.seeds[0], speed_mps=1.0, make=ThesisPilot)
    assert run.referee.end(run.watch) is Reason.FINISHED
    assert run.watch.faults == ()
    assert set(np.unique(run.commands[:, 0])) == {0.0, 1.0}


def test_a_lap_past_boxes_and_through_a_tunnel_without_a_collision() -> None:
    suite = load_suite("dev-d3")
    run = obey(suite, suite.seeds[0], speed_mps=1.0, make=ThesisPilot)
    assert run.referee.end(run.watch) is Reason.FINISHED
    assert run.touched == ()
    assert (run.commands[:, 0] == 0.5).any() or len(np.unique(run.commands[:, 0])) > 3  # the rule steered


def test_it_parks_from_a_stand_when_it_is_told_to() -> None:
    suite = load_suite("dev-p1")
    run = obey(suite, suite.seeds[0], speed_mps=1.0, make=ThesisPilot)
    assert run.watch.parked_s is not None
    assert run.watch.faults == ()


@pytest.mark.parametrize(("left_m", "turns"), [(0.0, 1), (0.775, -1)], ids=["own lane", "other lane"])
def test_the_lane_in_which_a_box_stands_chooses_the_side(left_m: float, turns: int) -> None:
    task = mission_for(load_suite("dev-d3"), latency_s=0.0, options={})
    hall = Hall([thing(START.x_m + 1.5, START.y_m + left_m, 0.6, 0.6)])
    pilot, state = begun(task)
    state = pilot.see(state, START, hall.scan(START))
    _, command = pilot.steer(state, START, Motion())
    assert np.sign(command.omega_radps) == turns
    assert command.v_mps < 1.0


@pytest.mark.parametrize("left_m", [-0.7, 1.5], ids=["right of the road", "left of the road"])
def test_what_stands_beside_the_road_is_not_gone_round(left_m: float) -> None:
    """A wall that leads across the way ahead, but not over the road."""
    task = mission_for(load_suite("dev-d3"), latency_s=0.0, options={})
    hall = Hall([thing(START.x_m + 1.8, START.y_m + left_m, 0.6, 0.5)])
    pilot, state = begun(task)
    state = pilot.see(state, START, hall.scan(START))
    assert pilot.steer(state, START, Motion())[1].v_mps == 1.0


def test_a_mission_without_things_to_go_round_looks_at_no_scan() -> None:
    task = mission_for(load_suite("dev-d2"), latency_s=0.0, options={})
    hall = Hall([thing(START.x_m + 1.5, START.y_m, 0.6, 0.6)])
    pilot, state = begun(task)
    assert pilot.see(state, START, hall.scan(START)) is state


def begun(task: Mission) -> tuple[ThesisPilot, ThesisProgress]:
    """Return a pilot that was sent straight on and has passed the crosswalk."""
    assert task.rig.laser == LASER
    pilot = ThesisPilot(mission=task, speed_mps=1.0)
    state = pilot.start()
    for _ in range(2):
        state = pilot.look(state, task.start_pose, panel("up"))
    state, _ = pilot.steer(state, task.start_pose, Motion())
    return pilot, pilot.steer(state, START, Motion(v_mps=1.0))[0]
