"""The referee on runs made by hand, and its parts against independent geometry."""

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from made_runs import COURSE, START_X_M, along, header_of, referee_of, watch_run

from adc_bench.evaluate.course_progress import Moment, crossing_s, progress_at, route_of
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.faults import FaultKind
from adc_bench.evaluate.ground import ground_of
from adc_bench.evaluate.programme import HalfLap
from adc_bench.evaluate.wheels import footing, poses_between
from adc_bench.geometry import Pose2
from adc_bench.world.layout import Layout

HEADER = header_of()
REFEREE = referee_of(HEADER)
LAP_M = COURSE.lap.length_m
START_S = REFEREE.start_s
GROUND = ground_of(COURSE, Layout(), None)
GATES = [
    gate
    for loop in ("east", "west")
    for way in ("straight", "turn")
    for gate in route_of(COURSE, HalfLap(loop=loop, way=way)).gates
]


@pytest.mark.parametrize("speed_mps", [1.3, 2.0])
def test_two_perfect_laps(speed_mps: float) -> None:
    _, watch, reason = watch_run(HEADER, along(HEADER, speed_mps))
    assert reason is Reason.FINISHED
    expected = [(LAP_M - START_X_M) / speed_mps, LAP_M / speed_mps]
    assert REFEREE.laps_s(watch) == pytest.approx(expected, abs=1e-9)
    assert REFEREE.finished_s(watch) == pytest.approx(START_S + sum(expected))
    assert REFEREE.completion(watch) == 1.0
    assert (watch.as_ordered, watch.half, watch.off_track_s, watch.faults) == (4, 4, 0.0, ())
    assert watch.set_out
    assert watch.distance_m == pytest.approx(2 * LAP_M - START_X_M, rel=1e-3, abs=0.1)


def test_a_robot_before_the_line_has_driven_nothing() -> None:
    progress = progress_at(COURSE, HalfLap(loop="east", way="straight"), HEADER.start_pose)
    assert progress.s_m == pytest.approx(START_X_M, abs=1e-9) and progress.share == 0.0


def test_standing_still_is_blocked_twenty_seconds_after_the_start() -> None:
    moments, watch, reason = watch_run(HEADER, lambda time_s: HEADER.start_pose)
    assert reason is Reason.BLOCKED
    assert moments[-1].time_s == pytest.approx(START_S + 20.0, abs=1e-6)
    assert REFEREE.completion(watch) == 0.0 and not watch.set_out


@pytest.mark.parametrize(("radius_m", "blocked"), [(0.09, True), (0.11, False)])
def test_who_stays_within_ten_centimetres_is_blocked(radius_m: float, blocked: bool) -> None:
    def to_and_fro(time_s: float) -> Pose2:
        away_m = radius_m * (round(time_s) % 2) if time_s > START_S + 1.0 else 0.0
        return HEADER.start_pose @ Pose2(x_m=away_m, y_m=0.0, yaw_rad=0.0)

    _, _, reason = watch_run(HEADER, to_and_fro)
    assert reason is (Reason.BLOCKED if blocked else Reason.TIME_LIMIT)


def test_creeping_runs_into_the_time_limit() -> None:
    moments, watch, reason = watch_run(HEADER, along(HEADER, 0.1))
    assert reason is Reason.TIME_LIMIT
    assert moments[-1].time_s == pytest.approx(START_S + HEADER.run.suite.time_limit_s, abs=1e-6)
    half_lap_m = route_of(COURSE, HalfLap(loop="east", way="straight")).length_m
    assert REFEREE.completion(watch) == pytest.approx((18.0 + START_X_M) / half_lap_m / 4, abs=1e-3)


def test_straight_on_leaves_the_road() -> None:
    def straight(time_s: float) -> Pose2:
        ahead_m = max(time_s - START_S, 0.0)
        return HEADER.start_pose @ Pose2(x_m=ahead_m, y_m=0.0, yaw_rad=0.0)

    _, watch, reason = watch_run(HEADER, straight)
    assert reason is Reason.OFF_ROAD
    assert [fault.kind for fault in watch.faults] == [FaultKind.LINE_TOUCH, FaultKind.OFF_ROAD]
    assert watch.off_track_s > 0
    assert watch.now.pose.x_m > 5.35


def test_setting_out_before_the_start_is_a_false_start() -> None:
    for wait_s, false_starts in ((-0.1, 1), (-0.04, 0)):  # four centimetres are allowed
        _, watch, _ = watch_run(HEADER, along(HEADER, 1.0, wait_s=wait_s))
        assert watch.count(FaultKind.FALSE_START) == false_starts


@pytest.mark.parametrize(("back_m", "wrong_ways"), [(0.95, 0), (1.05, 1)])
def test_more_than_a_metre_back_is_the_wrong_way_once(back_m: float, wrong_ways: int) -> None:
    def there_and_back(time_s: float) -> Pose2:
        driven_s = max(time_s - START_S, 0.0)
        s_m = driven_s if driven_s < 8.0 else max(16.0 - driven_s, 8.0 - back_m)
        return along(HEADER, 1.0)(START_S + s_m + (driven_s - 12.0 if driven_s > 12.0 else 0.0))

    _, watch, reason = watch_run(HEADER, there_and_back)
    assert reason is Reason.FINISHED
    assert [fault.kind for fault in watch.faults] == [FaultKind.WRONG_WAY] * wrong_ways


def test_a_short_cut_earns_nothing_beyond_the_next_gate() -> None:
    watch = replace(REFEREE.begin(HEADER.start_pose), best_m=18.0)
    gate = watch.progress.next_gate
    assert gate.name == "leg"
    assert REFEREE.completion(watch) == pytest.approx(gate.s_m / watch.progress.route.length_m / 4)


@pytest.mark.parametrize(("left_m", "touches"), [(-0.168, 0), (-0.174, 1), (-0.19, 1)])
def test_a_wheel_touches_the_line_at_its_edge(left_m: float, touches: int) -> None:
    """Outer line 0.3875 m to the right, half of it 0.025; the wheel reaches 0.165 + 0.025 m, its true track aside."""
    header = msgspec.structs.replace(HEADER, wheel_separation_m=0.33)
    pose_at = along(header, 1.0, left_m=lambda s_m: left_m if 10.0 < s_m < 11.0 else 0.0)
    _, watch, _ = watch_run(header, pose_at)
    assert watch.count(FaultKind.LINE_TOUCH) == touches


@pytest.mark.parametrize(("period_s", "touches"), [(1.9, 1), (3.0, 4)])
def test_touches_closer_than_two_seconds_are_one(period_s: float, touches: int) -> None:
    """A robot that weaves onto the outer line every 1.9 s touches once, every 3 s each time."""

    def left_m(s_m: float) -> float:
        return -0.19 if 6.0 < s_m < 18.0 and s_m % period_s > period_s - 0.5 else 0.0

    _, watch, _ = watch_run(HEADER, along(HEADER, 1.0, left_m=left_m))
    assert watch.count(FaultKind.LINE_TOUCH) == touches


@pytest.mark.parametrize(("left_m", "off_road"), [(-0.54, False), (-0.56, True)])
def test_the_road_is_left_when_both_wheels_are_outside(left_m: float, off_road: bool) -> None:
    """The line's middle is 0.3875 m to the right; the left wheel stands 0.165 m left of the robot's middle."""
    header = msgspec.structs.replace(HEADER, wheel_separation_m=0.33)
    _, watch, reason = watch_run(header, along(header, 1.0, left_m=lambda s_m: left_m if 10.0 < s_m < 10.5 else 0.0))
    assert reason is (Reason.OFF_ROAD if off_road else Reason.FINISHED)
    assert watch.count(FaultKind.OFF_ROAD) == off_road


@settings(max_examples=60, deadline=None)
@given(
    s_m=st.floats(0.0, LAP_M),
    left_m=st.floats(-0.6, 0.6),
    yaw_rad=st.floats(-math.pi, math.pi),
    ahead_m=st.floats(0.0, 0.12),
)
def test_wheels_against_polygons(s_m: float, left_m: float, yaw_rad: float, ahead_m: float) -> None:
    """Patches as line segments against buffered lines, at the very poses that the referee looks at."""
    before = COURSE.lap.pose(s_m) @ Pose2(x_m=0.0, y_m=left_m, yaw_rad=yaw_rad)
    now = before @ Pose2(x_m=ahead_m, y_m=0.0, yaw_rad=0.02)
    found = footing(GROUND, before, now, 0.33, 0.05)
    edges = shapely.MultiLineString(list(COURSE.edge_lines.values()))
    touched, off = [], []
    for x_m, y_m, yaw in poses_between(before, now):
        pose = Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw)
        for side in (0.165, -0.165):
            patch = shapely.LineString(pose.transform([(0.0, side - 0.025), (0.0, side + 0.025)]))
            touched.append(patch.distance(edges))
            off.append(not COURSE.road.contains(shapely.Point(pose.transform([(0.0, side)])[0])))
    if abs(min(touched) - 0.025) > 1e-3:
        assert found.on_line == (min(touched) < 0.025)
    assert found.a_wheel_off == any(off)
    assert found.all_off == any(left and right for left, right in zip(off[::2], off[1::2], strict=True))


@given(share=st.floats(0.01, 0.99), aside_m=st.floats(-1.0, 1.0), length_m=st.floats(0.01, 0.2))
def test_a_gate_is_crossed_at_the_interpolated_time(share: float, aside_m: float, length_m: float) -> None:
    for gate in GATES:
        ends = [
            gate.pose @ Pose2(x_m=x_m, y_m=aside_m, yaw_rad=0.0) for x_m in (-share * length_m, (1 - share) * length_m)
        ]
        before, now = Moment(time_s=3.0, pose=ends[0]), Moment(time_s=3.05, pose=ends[1])
        crossed_s = crossing_s(gate, before, now)
        if abs(aside_m) < gate.half_width_m - 1e-9:
            assert crossed_s == pytest.approx(3.0 + 0.05 * share, abs=1e-9)
        elif abs(aside_m) > gate.half_width_m + 1e-9:
            assert crossed_s is None
        assert crossing_s(gate, now, before) is None, "backwards does not count"


def test_poses_between_end_at_the_pose_and_turn_the_short_way() -> None:
    before = Pose2(x_m=0.0, y_m=0.0, yaw_rad=math.pi - 0.1)
    now = Pose2(x_m=0.1, y_m=0.0, yaw_rad=-math.pi + 0.1)
    poses = poses_between(before, now)
    assert poses[-1, :2] == pytest.approx([0.1, 0.0])
    assert np.diff(poses[:, 2]) == pytest.approx(0.2 / len(poses))
