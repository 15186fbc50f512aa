"""What the site shows of a run: its path, its estimates' errors and its events, in a few kilobytes.

Four poses a second, in whole millimetres and milliradians; the errors of the estimates, which may be smaller than
that, in micrometres and microradians. A run of three minutes is 40 kB of JSON. Nothing is scored from a trace; the
figures beside it are those of the full log.
"""

import hashlib
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.layout import write_file
from adc_bench.errors import InputError
from adc_bench.evaluate.events import Event, events_of
from adc_bench.evaluate.log import EpisodeLog, LocalizationLog, Row
from adc_bench.evaluate.recorded_log import LocalizationRow
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.score import Episode
from adc_bench.evaluate.summary import AnyEpisode
from adc_bench.geometry import wrap_rad

Array = NDArray[np.float64]
PERIOD_S = 0.25
LARGEST = 1000.0  # metres and radians: what lies beyond is drawn there
MILLI, MICRO = 1e3, 1e6

Column = tuple[int, ...]


class Estimate(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the submission believed the robot to be, seen from where it was: ahead, to the left, turned left.

    The standard deviations that it gave are in the same directions; none if it gave no covariances. An unanswered
    observation has the errors of the one before.
    """

    ahead_um: Column
    left_um: Column
    turn_urad: Column
    sd_ahead_um: Column | None
    sd_left_um: Column | None
    sd_turn_urad: Column | None


class Trace(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A line of `traces/<entry>.jsonl`: a run at times 0, `period_s`, 2 `period_s` ... and at its end, `end_s`.

    `yaw_mrad` counts whole turns on, so that it may be interpolated; `detail` is what a submission that failed said.
    """

    scenario: str
    period_s: float
    end_s: float
    x_mm: Column
    y_mm: Column
    yaw_mrad: Column
    estimate: Estimate | None  # none if it never answered
    events: tuple[Event, ...]
    detail: str


def trace_of(log: EpisodeLog | LocalizationLog, episode: AnyEpisode, rules: Rules = RULES) -> Trace:
    """Return the trace of a run and its score."""
    last, every = len(log.rows) - 1, round(PERIOD_S / rules.control_period_s)
    rows: list[Row | LocalizationRow] = [log.rows[index] for index in (*range(0, last, every), last)]
    yaw_rad = np.unwrap([row.truth.yaw_rad for row in rows])
    return Trace(
        scenario=log.header.scenario,
        period_s=PERIOD_S,
        end_s=log.rows[-1].time_s,
        x_mm=_whole([row.truth.x_m for row in rows], MILLI),
        y_mm=_whole([row.truth.y_m for row in rows], MILLI),
        yaw_mrad=_whole(yaw_rad, MILLI),
        estimate=_estimate(rows),
        events=_events(log, episode),
        detail=log.ending.detail,
    )


def _events(log: EpisodeLog | LocalizationLog, episode: AnyEpisode) -> tuple[Event, ...]:
    """Return what happened in a run; a recording only ends."""
    if isinstance(log, EpisodeLog) and isinstance(episode, Episode):
        return events_of(log, episode)
    text = f"{episode.reason.replace('-', ' ')} ({episode.status})"
    return (Event(time_s=round(log.rows[-1].time_s, 3), kind="end", text=text),)


def _estimate(rows: Sequence[Row | LocalizationRow]) -> Estimate | None:
    errors, deviations = _errors(rows), _deviations(rows)
    if errors is None:
        return None
    ahead, left, turn = (_whole(column, MICRO) for column in errors.T)
    sds = [None] * 3 if deviations is None else [_whole(column, MICRO) for column in deviations.T]
    return Estimate(
        ahead_um=ahead,
        left_um=left,
        turn_urad=turn,
        sd_ahead_um=sds[0],
        sd_left_um=sds[1],
        sd_turn_urad=sds[2],
    )


def _errors(rows: Sequence[Row | LocalizationRow]) -> Array | None:
    """Return the estimates seen from the truth (n, 3); None if there are none."""
    found: list[tuple[float, float, float]] = []
    for row in rows:
        if row.answer is not None:
            seen = row.truth.inverse() @ row.answer.estimate
            found.append((seen.x_m, seen.y_m, wrap_rad(seen.yaw_rad)))
        elif found:
            found.append(found[-1])
        else:
            return None
    return np.array(found)


def _deviations(rows: Sequence[Row | LocalizationRow]) -> Array | None:
    """Return the standard deviations (n, 3) along the robot's own axes; None unless every answer has a covariance."""
    covariances = [row.answer.covariance for row in rows if row.answer is not None]
    given = [covariance for covariance in covariances if covariance is not None]
    if not given or len(given) < len(covariances):
        return None
    given += [given[-1]] * (len(rows) - len(given))
    world = np.array(given).reshape(-1, 3, 3)
    yaw_rad = np.array([row.truth.yaw_rad for row in rows])
    turned = np.zeros_like(world)
    turned[:, 0, 0] = turned[:, 1, 1] = np.cos(yaw_rad)
    turned[:, 0, 1], turned[:, 1, 0], turned[:, 2, 2] = np.sin(yaw_rad), -np.sin(yaw_rad), 1.0
    variances = np.einsum("nij,njk,nik->ni", turned, world, turned)
    deviations: Array = np.sqrt(np.maximum(variances, 0.0))
    return deviations


def _whole(values: Sequence[float] | Array, per_unit: float) -> Column:
    bounded = np.clip(np.asarray(values, dtype=np.float64), -LARGEST, LARGEST)
    return tuple(np.rint(bounded * per_unit).astype(int).tolist())


def write_traces(path: Path, traces: Sequence[Trace]) -> str:
    """Write the traces of an entry and return their digest."""
    data = b"".join(msgspec.json.encode(trace) + b"\n" for trace in traces)
    write_file(path, data)
    return hashlib.sha256(data).hexdigest()


def read_traces(path: Path, sha256: str) -> list[Trace]:
    """Return the traces in a file.

    Raises:
        InputError: there is no such file, or it is not the one with this digest.
    """
    data = path.read_bytes() if path.is_file() else b""
    if hashlib.sha256(data).hexdigest() != sha256:
        found = "other traces than those of the entry" if data else "no such file"
        raise InputError(where=str(path), found=found, wanted=f"sha256 {sha256[:12]}", todo="add the result again")
    return [msgspec.json.decode(line, type=Trace) for line in data.splitlines()]
