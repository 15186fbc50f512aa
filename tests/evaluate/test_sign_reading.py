"""Vertical signs: which are passed, and when a report of one is right."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_runs import COURSE, PERIOD_S, START_X_M, along, header_of, log_of, referee_of

from adc_bench.evaluate.course_progress import Route, route_of
from adc_bench.evaluate.faults import FaultKind
from adc_bench.evaluate.programme import HalfLap, Programme
from adc_bench.evaluate.score import Episode, score
from adc_bench.evaluate.sign_reading import sign_stations_m
from adc_bench.evaluate.suite import load_suite
from adc_bench.world.categories import SIGNS, SignCategory

V1 = header_of(load_suite("v1"))
LAP = header_of(load_suite("dev-v1"))
START_S = LAP.start_step * PERIOD_S
SPEED_MPS = 2.0


def routes(half_laps: tuple[HalfLap, ...]) -> list[Route]:
    return [route_of(COURSE, half_lap) for half_lap in half_laps]


def test_a_lap_each_way_round_passes_all_twelve_signs_once() -> None:
    due = [sign_stations_m(route, V1.signs) for route in routes(Programme(orders=V1.orders).half_laps)]
    assert [len(stations) for stations in due] == [3, 3, 3, 3]
    assert {sign for stations in due for sign in stations} == set(SIGNS)


@given(st.integers(0, 3))
def test_a_sign_that_is_due_stands_beside_the_lane_and_faces_the_driver(half: int) -> None:
    route = routes(Programme(orders=V1.orders).half_laps)[half]
    signs = {sign.sign: sign for sign in V1.signs}
    for category, station_m in sign_stations_m(route, V1.signs).items():
        pose, sign = route.pose(station_m), signs[category]
        (ahead_m, left_m), *_ = pose.inverse().transform([(sign.x_m, sign.y_m)])
        assert ahead_m == pytest.approx(0.0, abs=1e-6) and 0.4 < abs(left_m) < 0.9
        assert math.cos(sign.yaw_rad - pose.yaw_rad) < -0.9


def due_s(ahead_m: float) -> list[tuple[float, SignCategory]]:
    """Return the times at which a robot at SPEED_MPS is so far before each sign of a lap, and the signs."""
    found, begun_m = [], -START_X_M
    for route in routes(Programme(orders=LAP.orders).half_laps):
        for sign, station_m in sign_stations_m(route, LAP.signs).items():
            found.append((START_S + (begun_m + station_m - ahead_m) / SPEED_MPS, sign))
        begun_m += route.length_m
    return sorted(found)


def lap(reports: dict[float, SignCategory]) -> Episode:
    return score(log_of(LAP, along(LAP, SPEED_MPS), reports=reports))


def test_all_signs_read_and_none() -> None:
    told, silent = lap(dict(due_s(1.0))), lap({})
    assert (told.signs_read, told.faults, told.driving_score) == ((6, 6), (), 100.0)
    assert silent.signs_read == (0, 6)
    assert [fault.what for fault in silent.faults] == [sign for _, sign in due_s(0.0)]
    assert told.points - silent.points == pytest.approx(60.0)
    assert silent.driving_score == pytest.approx(100 * 0.9**6)


@pytest.mark.parametrize(("ahead_m", "right"), [(4.1, False), (3.9, True), (0.0, True), (-0.85, True), (-1.15, False)])
def test_from_four_metres_before_the_sign_to_one_behind(ahead_m: float, right: bool) -> None:
    """A step is 0.1 m."""
    time_s, sign = due_s(ahead_m)[1]
    episode = lap({time_s: sign})
    assert episode.signs_read == (int(right), 6)
    assert [fault.what for fault in episode.faults if fault.kind is FaultKind.FALSE_REPORT] == [sign] * (not right)


def test_a_sign_reported_again_and_again_counts_once_right_or_wrong() -> None:
    times_s, sign = [due_s(ahead_m)[1][0] for ahead_m in (3.0, 2.0, 1.0)], due_s(0.0)[1][1]
    assert lap(dict.fromkeys(times_s, sign)).signs_read == (1, 6)
    there = {sign for _, sign in due_s(0.0)}
    absent = next(sign for sign in SIGNS if sign not in there)
    episode = lap(dict.fromkeys(times_s, absent))
    assert sum(fault.kind is FaultKind.FALSE_REPORT for fault in episode.faults) == 1
    assert episode.signs_read == (0, 6)


def test_reporting_everything_everywhere_does_not_pay() -> None:
    """Every sign at every moment, in turns: each is once right, and wrong in the half lap in which it is not."""
    steps = range(1, 400)
    episode = lap({START_S + step * PERIOD_S: SIGNS[step % len(SIGNS)] for step in steps})
    false_reports = sum(fault.kind is FaultKind.FALSE_REPORT for fault in episode.faults)
    assert episode.signs_read == (6, 6) and false_reports >= 18
    assert episode.points < lap({}).points and episode.driving_score < lap({}).driving_score


def test_reports_are_not_looked_at_where_none_are_asked_for() -> None:
    header = header_of(load_suite("dev"))
    episode = score(log_of(header, along(header, 2.0), reports={5.0: "sign_dip"}))
    assert episode.signs_read is None and episode.faults == ()
    assert not referee_of(header).programme.parks and episode.parked is None
