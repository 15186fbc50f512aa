"""Scores and result files of runs made by hand."""

import json
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_runs import COURSE, START_X_M, along, header_of, log_of

from adc_bench.evaluate.ending import STATUS_OF, Ending, Reason
from adc_bench.evaluate.log import EpisodeLog, Hit, Row, read_log, write_log
from adc_bench.evaluate.results import episode_timing, result_of, timing_of, to_json
from adc_bench.evaluate.score import merge_hits, score
from adc_bench.evaluate.suite import load_suite
from adc_bench.evaluate.summary import METRICS
from adc_bench.geometry import Pose2
from adc_bench.world.route import half_lap

HEADER = header_of()
LAP_M = COURSE.lap.length_m
ROW = log_of(HEADER, lambda time_s: HEADER.start_pose).rows[0]


def test_the_points_of_a_perfect_run() -> None:
    episode = score(log_of(HEADER, along(HEADER, 1.0)))
    run_time_s = 2 * LAP_M - START_X_M
    assert episode.run_time_s == pytest.approx(run_time_s)
    assert episode.points == pytest.approx(4 * 50 + 140 - run_time_s)
    assert episode.driving_score == 100.0
    assert (episode.status, episode.reason) == ("success", Reason.FINISHED)
    assert (episode.driving.signs_obeyed, episode.driving.signs_shown) == (5, 5)
    assert episode.driving.cross_track_max_m == pytest.approx(0.0, abs=1e-9)


def test_localization_is_measured_from_the_arrow_on() -> None:
    episode = score(log_of(HEADER, along(HEADER, 1.0), error_m=0.03))
    found = episode.localization
    assert found is not None
    assert (found.position_rmse_m, found.position_max_m) == pytest.approx((0.03, 0.03))
    assert found.heading_rmse_rad == pytest.approx(0.0, abs=1e-12)
    assert found.coverage is not None and 0 < found.coverage <= 1
    assert found.dead_reckoning_max_m > 8.0, "its wheels stood still"


def test_each_fault_costs_its_points_and_its_factor() -> None:
    wall = Hit(time_s=12.0, with_name="wall_east", impulse_ns=2.0)
    episode = score(log_of(HEADER, along(HEADER, 1.0, wait_s=-0.2), hits=[wall]))
    run_time_s = 2 * LAP_M - START_X_M - 0.2
    assert episode.points == pytest.approx(200 + 140 - run_time_s - 60 - 20)
    assert episode.driving_score == pytest.approx(100 * 0.7 * 0.7)
    assert episode.collisions == (wall,)
    assert episode.driving.signs_obeyed == 4
    assert [(fault.kind, fault.what) for fault in episode.faults] == [("false_start", ""), ("collision", "wall_east")]


def test_a_run_without_all_laps_earns_its_half_laps_only() -> None:
    def half(time_s: float) -> Pose2:
        return along(HEADER, 1.0)(min(time_s, HEADER.start_step * 0.05 + 30.0))

    episode = score(log_of(HEADER, half))
    assert (episode.status, episode.reason, episode.laps_s, episode.run_time_s) == ("timeout", Reason.BLOCKED, (), None)
    assert episode.points == 50.0
    halves_m = [sum(p.length_m for p in half_lap(COURSE, loop, "straight")) for loop in ("east", "west")]
    assert episode.completion == pytest.approx((1 + (30.0 + START_X_M - halves_m[0]) / halves_m[1]) / 4, abs=1e-6)


@pytest.mark.parametrize("reason", [Reason.STEP_RAISED, Reason.NOT_FINITE])
def test_a_submission_that_breaks_earns_nothing_however_far_it_came(reason: Reason) -> None:
    log = log_of(HEADER, along(HEADER, 2.0))
    episode = score(EpisodeLog(header=log.header, rows=log.rows, ending=Ending(reason=reason)))
    assert episode.failed and episode.completion == 1.0
    assert (episode.points, episode.driving_score) == (0.0, 0.0)


def test_hits_on_one_object_in_a_row_are_one_collision() -> None:
    hits = [
        Hit(time_s=t, with_name=name, impulse_ns=1.0) for t, name in ((1.0, "a"), (1.5, "a"), (1.6, "b"), (3.0, "a"))
    ]
    merged = merge_hits(hits, gap_s=1.0)
    assert [(hit.time_s, hit.with_name, hit.impulse_ns) for hit in merged] == [
        (1.0, "a", 2.0),
        (1.6, "b", 1.0),
        (3.0, "a", 1.0),
    ]


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=3, max_size=3))
def test_floats_come_back_from_a_log_as_they_were(figures: list[float]) -> None:
    row = msgspec.structs.replace(ROW, truth=Pose2(x_m=figures[0], y_m=figures[1], yaw_rad=figures[2]))
    assert msgspec.json.decode(msgspec.json.encode(row), type=Row) == row


def test_the_score_of_a_log_read_back_is_the_same(tmp_path: Path) -> None:
    log = log_of(HEADER, along(HEADER, 1.1))
    write_log(tmp_path / "run.jsonl", log.header, log.rows, log.ending)
    again = read_log(tmp_path / "run.jsonl")
    assert again == log
    assert to_json(score(again)) == to_json(score(log))


def test_a_result_is_strict_sorted_and_eligible_only_whole() -> None:
    suite = msgspec.structs.replace(load_suite("d1"), seeds=(7001, 7002, 7003))
    logs = [log_of(header, along(header, 3.0)) for header in (header_of(suite, seed) for seed in suite.seeds)]
    whole, part = result_of(logs, 3), result_of(logs[:2], 3)
    assert (whole.status, whole.eligible, whole.completed) == ("success", True, 3)
    assert (part.status, part.eligible, part.completed) == ("aborted", False, 2)
    assert result_of(logs[:1], 1).eligible is False
    text = to_json(whole).decode()
    data = json.loads(text, parse_constant=lambda name: pytest.fail(name))
    assert text == json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False) + "\n" or list(data) == sorted(data)
    assert set(whole.summary) == set(METRICS["driver"]) - {"vertical_signs_read"}
    assert whole.summary["lap_time_s"].n == 3
    assert set(data["episodes"][0]) >= {"scenario", "seed", "status", "laps_s", "localization", "driving", "points"}


def test_a_metric_that_no_run_has_is_left_out() -> None:
    summary = result_of([log_of(HEADER, lambda time_s: HEADER.start_pose)], 1).summary
    assert "run_time_s" not in summary and "lap_time_s" not in summary
    assert summary["completion"].mean == 0.0


def test_every_reason_has_a_status() -> None:
    assert set(STATUS_OF) == set(Reason)


def test_the_latency_verdict() -> None:
    fast, slow = (episode_timing(1.0, 2.0, [step_s] * 20, "none") for step_s in (0.01, 0.2))
    assert fast.wall_per_sim == 0.5
    assert timing_of({"a": fast}, 0.0, 0.05).latency.verdict == "within"
    assert timing_of({"a": fast, "b": slow}, 0.0, 0.05).latency.verdict == "exceeded"
    assert timing_of({"a": fast, "b": slow}, 0.15, 0.05).latency.verdict == "within"
    assert timing_of({"a": episode_timing(1.0, 0.0, [], "none")}, 0.0, 0.05).latency.verdict == "not measured"
