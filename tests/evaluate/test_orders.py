"""Each rule on orders with a run that just breaks it and one that just does not."""

from itertools import pairwise

import msgspec
import pytest
from made_runs import COURSE, PERIOD_S, PoseAt, along, crosswalks_m, header_of, referee_of, watch_run

from adc_bench.evaluate.course_progress import Moment
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.faults import FaultKind
from adc_bench.evaluate.log import Header
from adc_bench.evaluate.programme import Trial
from adc_bench.evaluate.referee_watch import Watch
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.suite import load_suite
from adc_bench.world.categories import PanelSign
from adc_bench.world.layout import Layout, Works

NOSE_TO_LINE_M = RULES.course.crosswalk_depth_m / 2 + RULES.robot.length_m / 2  # from the crosswalk's middle


def header(*orders: PanelSign) -> Header:
    suite = msgspec.structs.replace(load_suite("dev-d2"), trials=(Trial(orders=orders),))
    return header_of(suite)


def kinds(watch: Watch) -> list[FaultKind]:
    return [fault.kind for fault in watch.faults]


def shown_at(run: Header, pose_at: PoseAt) -> list[tuple[PanelSign, float]]:
    """Return what the panels show in a run, and from when on."""
    referee = referee_of(run)
    watches = [referee.begin(pose_at(0.0))]
    while referee.end(watches[-1]) is None:
        time_s = len(watches) * PERIOD_S
        watches.append(referee.step(watches[-1], Moment(time_s=time_s, pose=pose_at(time_s))))
    changes = [after for before, after in pairwise(watches) if after.shown != before.shown]
    return [(referee.panels(watches[0]), 0.0), *((referee.panels(watch), watch.now.time_s) for watch in changes)]


def test_signs_change_in_the_middle_of_the_loop_and_after_a_stop() -> None:
    run = header("up", "stop", "right", "end")
    half_m = crosswalks_m(run.orders)[0]
    halt_m = half_m - NOSE_TO_LINE_M - 0.3
    found = shown_at(run, along(run, 1.0, halts={halt_m: 3.0}))
    assert [sign for sign, _ in found] == ["stop", "up", "stop", "right", "end"]
    start_s = run.start_step * PERIOD_S
    loop_m = 5.35 + COURSE.spec.lane_outer_radius_m * 0.75 * 3.14159265
    assert found[1][1] == pytest.approx(start_s)
    assert found[2][1] == pytest.approx(start_s + 0.65 + loop_m, abs=0.06)
    assert found[3][1] == pytest.approx(start_s + 0.65 + halt_m + RULES.stop_s, abs=0.06)


@pytest.mark.parametrize("orders", [("up", "right", "end"), ("left", "up", "end"), ("left", "right", "end")])
def test_turning_as_ordered_is_no_fault(orders: tuple[PanelSign, ...]) -> None:
    run = header(*orders)
    _, watch, reason = watch_run(run, along(run, 2.0))
    assert (reason, kinds(watch), watch.as_ordered, watch.obeyed) == (Reason.FINISHED, [], 2, 2)


@pytest.mark.parametrize("driven", [("up", "up", "end"), ("up", "right", "end"), ("left", "up", "end")])
def test_a_half_lap_the_other_way_is_a_fault_and_does_not_count(driven: tuple[PanelSign, ...]) -> None:
    run = header("left", "right", "end")
    wrong = sum(a != b for a, b in zip(run.orders, driven, strict=True))
    _, watch, reason = watch_run(run, along(run, 2.0, orders=driven))
    assert reason is Reason.FINISHED and watch.half == 2
    assert kinds(watch) == [FaultKind.ORDER_DISOBEYED] * wrong
    assert watch.as_ordered == 2 - wrong
    assert referee_of(run).completion(watch) == pytest.approx(1 - wrong / 2)


@pytest.mark.parametrize(
    ("room_m", "halt_s", "fault"),
    [
        (0.01, 2.1, None),
        (0.59, 2.1, None),
        (-0.01, 2.1, FaultKind.STOP_OUTSIDE_ZONE),
        (0.61, 2.1, FaultKind.STOP_OUTSIDE_ZONE),
        (2.99, 2.1, FaultKind.STOP_OUTSIDE_ZONE),
        (3.01, 2.1, FaultKind.STOP_PASSED),
        (0.30, 1.9, FaultKind.STOP_PASSED),
    ],
)
def test_the_stop_zone_and_how_long_to_stand(room_m: float, halt_s: float, fault: FaultKind | None) -> None:
    run = header("up", "stop", "up", "end")
    halt_m = crosswalks_m(run.orders)[0] - NOSE_TO_LINE_M - room_m
    _, watch, reason = watch_run(run, along(run, 2.0, halts={halt_m: halt_s}))
    assert reason is Reason.FINISHED
    assert kinds(watch) == ([fault] if fault else [])
    assert watch.obeyed == (3 if fault is None else 2)


def test_a_stop_in_the_other_lane_is_outside_the_zone() -> None:
    run = header("up", "stop", "up", "end")
    for left_m, faults in ((0.38, []), (0.40, [FaultKind.STOP_OUTSIDE_ZONE])):
        half_m = crosswalks_m(run.orders)[0]

        def aside(s_m: float, half_m: float = half_m, left_m: float = left_m) -> float:
            return left_m if half_m - 3.0 < s_m < half_m else 0.0

        pose_at = along(run, 2.0, left_m=aside, halts={half_m - NOSE_TO_LINE_M - 0.3: 2.1})
        assert kinds(watch_run(run, pose_at)[1]) == faults


@pytest.mark.parametrize(("length_m", "faults"), [(6.6, 0), (7.0, 1), (9.5, 1)])
def test_the_other_lane_is_for_passing(length_m: float, faults: int) -> None:
    """Half a metre to the left the bend is shorter by a fifth: 6 m there are 6.8 m of the lane, and the way over."""
    run = header("up", "up", "end")
    _, watch, _ = watch_run(run, along(run, 1.0, left_m=lambda s_m: 0.5 if 8.0 < s_m < 8.0 + length_m else 0.0))
    assert kinds(watch) == [FaultKind.WRONG_LANE] * faults


def with_works(way_out_m: float) -> tuple[Header, PoseAt]:
    """Return a run past road-works beside the +x loop's leg, and a robot so far to the right of its lane there."""
    lane_y_m = -COURSE.spec.lane_outer_radius_m
    works = Works(
        left=((1.0, lane_y_m - 0.2), (3.0, lane_y_m - 0.2)), right=((1.0, lane_y_m - 1.2), (3.0, lane_y_m - 1.2))
    )
    run = msgspec.structs.replace(header("up", "up", "end"), layout=Layout(works=works))
    return run, along(run, 1.0, left_m=lambda s_m: -way_out_m if 0.5 < s_m < 3.5 else 0.0)


@pytest.mark.parametrize(("way_out_m", "faults"), [(0.19, 1), (0.21, 0), (0.7, 0), (1.19, 0)])
def test_road_works_are_driven_through(way_out_m: float, faults: int) -> None:
    """Within the cones it matters neither that the way leaves the road nor what lines it crosses."""
    run, pose_at = with_works(way_out_m)
    _, watch, reason = watch_run(run, pose_at)
    assert reason is Reason.FINISHED
    assert kinds(watch) == [FaultKind.WORKS_MISSED] * faults
