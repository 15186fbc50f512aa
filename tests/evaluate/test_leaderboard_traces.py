"""What the site keeps of a run, against its log."""

import math

import msgspec
import numpy as np
import pytest
from made_runs import along_lap, header_of, log_of

from adc_bench.evaluate.log import EpisodeLog, Hit
from adc_bench.evaluate.score import score
from adc_bench.geometry import Pose2
from adc_bench.leaderboard.traces import Trace, trace_of


@pytest.fixture(scope="module")
def log() -> EpisodeLog:
    header = header_of()
    hits = [Hit(time_s=12.02 + 0.05 * k, with_name="cone_3", impulse_ns=0.5) for k in range(3)]
    return log_of(header, along_lap(header, 2.0, left_m=-0.3, wait_s=0.2), hits, error_m=0.02)


@pytest.fixture(scope="module")
def trace(log: EpisodeLog) -> Trace:
    return trace_of(log, score(log))


def test_the_path_is_the_log_s_to_the_millimetre(log: EpisodeLog, trace: Trace) -> None:
    rows = [*log.rows[:-1:5], log.rows[-1]]
    times_s = np.minimum(np.arange(len(trace.x_mm)) * trace.period_s, trace.end_s)
    assert times_s == pytest.approx([row.time_s for row in rows])
    assert np.array([trace.x_mm, trace.y_mm]) / 1000 == pytest.approx(
        np.array([(row.truth.x_m, row.truth.y_m) for row in rows]).T, abs=0.00051
    )
    turned = np.array(trace.yaw_mrad) / 1000 - [row.truth.yaw_rad for row in rows]
    assert np.abs(np.angle(np.exp(1j * turned))).max() < 0.00051
    assert np.abs(np.diff(trace.yaw_mrad)).max() < 1000


def test_errors_are_seen_from_the_robot(trace: Trace) -> None:
    """The made estimates are 2 cm ahead, all the way round."""
    assert trace.estimate is not None
    assert set(trace.estimate.ahead_um) == {20_000}
    assert set(trace.estimate.left_um) == set(trace.estimate.turn_urad) == {0}


def test_deviations_turn_with_the_robot(log: EpisodeLog, trace: Trace) -> None:
    """The made covariances are of the world's axes: along x 2 cm, along y a metre."""
    assert trace.estimate is not None and trace.estimate.sd_ahead_um and trace.estimate.sd_left_um
    for row, ahead_um, left_um in zip(
        [*log.rows[:-1:5]], trace.estimate.sd_ahead_um, trace.estimate.sd_left_um, strict=False
    ):
        cos, sin = math.cos(row.truth.yaw_rad), math.sin(row.truth.yaw_rad)
        assert ahead_um == pytest.approx(1e6 * math.hypot(0.02 * cos, sin), abs=0.51)
        assert left_um == pytest.approx(1e6 * math.hypot(0.02 * sin, cos), abs=0.51)


def test_events_tell_what_the_score_counts(log: EpisodeLog, trace: Trace) -> None:
    found, laps = score(log), [event for event in trace.events if event.kind == "lap"]
    faults = [event.text for event in trace.events if event.kind == "fault"]
    assert len(faults) == len(found.faults)
    assert faults.count("collision: cone 3") == len(found.collisions) == 1
    assert faults.count("line touch") == found.driving.line_touches > 0
    assert [event.text for event in laps] == [f"lap {k} in {found.laps_s[k - 1]:.2f} s" for k in (1, 2)]
    assert found.run_time_s is not None
    assert laps[-1].time_s == pytest.approx(found.arrow_s + found.run_time_s, abs=0.001)
    assert trace.events[0].text == "panels: stop" and trace.events[-1].text == "finished (success)"
    times_s = [event.time_s for event in trace.events]
    assert times_s == sorted(times_s) and times_s[-1] == trace.end_s


def test_a_trace_is_small(trace: Trace) -> None:
    assert len(msgspec.json.encode(trace)) < 230 * len(trace.x_mm)


def test_silence_leaves_no_estimate(log: EpisodeLog) -> None:
    silent = msgspec.structs.replace(log, rows=(msgspec.structs.replace(log.rows[0], answer=None),))
    found = trace_of(silent, score(silent))
    assert found.estimate is None and len(found.x_mm) == 1 and found.end_s == 0.0


def test_estimates_beyond_all_bounds_are_cut(log: EpisodeLog) -> None:
    lost = tuple(
        msgspec.structs.replace(
            row,
            answer=row.answer and msgspec.structs.replace(row.answer, estimate=Pose2(x_m=1e12, y_m=0.0, yaw_rad=0.0)),
        )
        for row in log.rows[:20]
    )
    found = trace_of(msgspec.structs.replace(log, rows=lost), score(log)).estimate
    assert found is not None and max(found.ahead_um) == 1_000_000_000
