"""The referee on runs made by hand, and its parts against independent geometry."""

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from made_runs import COURSE, PERIOD_S, along_lap, header_of, referee_of, watch_run

from adc_bench.evaluate.course_progress import Moment, crossing_s, progress_at
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.wheels import footing, poses_between
from adc_bench.geometry import Pose2

HEADER = header_of()
REFEREE = referee_of(HEADER)
LAP_M = COURSE.lap.length_m
ARROW_S = REFEREE.arrow_s


@pytest.mark.parametrize("speed_mps", [1.3, 2.0])
def test_two_perfect_laps(speed_mps: float) -> None:
    _, watch, reason = watch_run(HEADER, along_lap(HEADER, speed_mps))
    assert reason is Reason.FINISHED
    expected = [(LAP_M - RULES.start_x_m) / speed_mps, LAP_M / speed_mps]
    assert REFEREE.laps_s(watch) == pytest.approx(expected, abs=1e-9)
    assert REFEREE.completion(watch) == 1.0
    assert REFEREE.half_laps(watch) == 4
    assert (watch.line_touches, watch.off_track_s, watch.wrong_ways, watch.false_start) == (0, 0.0, 0, False)
    assert watch.set_out
    assert watch.distance_m == pytest.approx(2 * LAP_M - RULES.start_x_m, rel=1e-3, abs=0.1)


def test_a_robot_before_the_line_has_driven_nothing() -> None:
    assert progress_at(COURSE, HEADER.start_pose).progress_m == pytest.approx(RULES.start_x_m, abs=1e-9)


def test_standing_still_is_blocked_twenty_seconds_after_the_arrow() -> None:
    moments, watch, reason = watch_run(HEADER, lambda time_s: HEADER.start_pose)
    assert reason is Reason.BLOCKED
    assert moments[-1].time_s == pytest.approx(ARROW_S + 20.0, abs=1e-6)
    assert REFEREE.completion(watch) == 0.0 and not watch.set_out


def test_creeping_runs_into_the_time_limit() -> None:
    moments, watch, reason = watch_run(HEADER, along_lap(HEADER, 0.1))
    assert reason is Reason.TIME_LIMIT
    assert moments[-1].time_s == pytest.approx(ARROW_S + HEADER.run.suite.time_limit_s, abs=1e-6)
    assert REFEREE.completion(watch) == pytest.approx((18.0 + RULES.start_x_m) / (2 * LAP_M), abs=1e-3)


def test_straight_on_leaves_the_road() -> None:
    def straight(time_s: float) -> Pose2:
        ahead_m = max(time_s - ARROW_S, 0.0)
        return HEADER.start_pose @ Pose2(x_m=ahead_m, y_m=0.0, yaw_rad=0.0)

    _, watch, reason = watch_run(HEADER, straight)
    assert reason is Reason.OFF_ROAD
    assert watch.line_touches == 1
    assert watch.off_track_s > 0
    assert watch.now.pose.x_m > 5.35


def test_setting_out_before_the_arrow_is_a_false_start() -> None:
    early = along_lap(HEADER, 1.0, wait_s=-0.1)
    _, watch, _ = watch_run(HEADER, early)
    assert watch.false_start
    _, watch, _ = watch_run(HEADER, along_lap(HEADER, 1.0, wait_s=-0.04))
    assert not watch.false_start, "four centimetres are allowed"


def test_driving_backwards_is_the_wrong_way_once() -> None:
    _, watch, reason = watch_run(HEADER, along_lap(HEADER, -1.0))
    assert reason is Reason.BLOCKED
    assert watch.wrong_ways == 1
    assert REFEREE.completion(watch) == 0.0


def test_the_second_panel_pass_counts_only_after_the_gates_before_it() -> None:
    watch = REFEREE.begin(HEADER.start_pose)
    times_s = tuple(float(k) for k in range(4))
    for passed, half_laps in ((0, 0), (3, 0), (4, 1)):
        progress = replace(watch.progress, gate_times_s=times_s[:passed])
        assert REFEREE.half_laps(replace(watch, progress=progress)) == half_laps


def test_a_short_cut_earns_nothing_beyond_the_next_gate() -> None:
    watch = replace(REFEREE.begin(HEADER.start_pose), best_m=30.0)
    assert REFEREE.completion(watch) == pytest.approx(COURSE.gates[0].s_m / (2 * LAP_M))


def test_touches_closer_than_two_seconds_are_one() -> None:
    """A robot that weaves onto the outer line once a second touches once, once in three seconds each time."""
    for period_s, expected in ((1.0, 1), (3.0, 4)):

        def weaving(time_s: float, period_s: float = period_s) -> Pose2:
            driven_s = max(time_s - ARROW_S, 0.0)
            aside_m = -0.19 if (driven_s % period_s) > period_s - 0.5 else 0.0
            place_m = 10.0 + 0.05 * driven_s
            return COURSE.lap.pose(place_m) @ Pose2(x_m=0.0, y_m=aside_m, yaw_rad=0.0)

        header = msgspec.structs.replace(HEADER, start_pose=COURSE.lap.pose(10.0))
        referee = referee_of(header)
        watch = referee.begin(header.start_pose)
        for step in range(1, round((ARROW_S + 12.0) / PERIOD_S)):
            now = Moment(time_s=step * PERIOD_S, pose=weaving(step * PERIOD_S))
            watch = referee.step(watch, now)
        assert watch.line_touches == expected


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
    found = footing(COURSE, before, now, 0.33, 0.05)
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
    for gate in COURSE.gates:
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
