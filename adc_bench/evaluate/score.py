"""A run's score: a pure function of its log."""

import math
from collections.abc import Sequence
from itertools import accumulate

import msgspec
import numpy as np

from adc_bench.evaluate.course_progress import Moment
from adc_bench.evaluate.ending import FAILED, Reason, Status
from adc_bench.evaluate.faults import Fault, FaultKind
from adc_bench.evaluate.log import EpisodeLog, Hit, Row
from adc_bench.evaluate.metrics import Localization, localization, pose_array, replayed, rms
from adc_bench.evaluate.referee import Referee
from adc_bench.evaluate.referee_watch import Watch
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.sign_reading import SignReading, read_signs
from adc_bench.evaluate.suite import rules_for
from adc_bench.world.course import Course


class Driving(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the run was driven. `off_track_s`: time with a wheel beyond the middle of the road's edge line.

    Cross-track errors are against the middle of the right-hand lane of the half lap that is being driven, from the
    start on (none for a run that only parks, or ended before). The first order is obeyed by a robot that waits for it
    and then sets out; the others as docs/rules.md says.
    """

    cross_track_rmse_m: float | None
    cross_track_max_m: float | None
    line_touches: int
    off_track_s: float
    wrong_ways: int
    signs_obeyed: int
    signs_shown: int


class Episode(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="driver"):
    """The score of one run. One that `failed` has 0 points and driving score, however far it came."""

    scenario: str
    seed: int
    light_level: str
    status: Status
    reason: Reason
    sim_time_s: float
    arrow_s: float  # when the first order appeared
    run_time_s: float | None  # from there to the last crossing, or to rest in a place; none if the run was not finished
    laps_s: tuple[float, ...]
    parked: bool | None  # none where one does not park
    signs_read: tuple[int, int] | None  # vertical signs read right and passed; none where they are not to be read
    distance_m: float
    completion: float
    localization: Localization | None  # none if there is no estimate after the start
    driving: Driving
    collisions: tuple[Hit, ...]
    faults: tuple[Fault, ...]  # all of them, in order of time
    points: float
    driving_score: float

    @property
    def failed(self) -> bool:
        """Whether the submission broke as a program."""
        return self.status in FAILED


def score(log: EpisodeLog, rules: Rules = RULES) -> Episode:
    """Return the score of a run."""
    suite = log.header.suite
    rules = rules_for(suite, rules)
    referee = Referee(course=Course(spec=rules.course), rules=rules, header=log.header)
    watches = _watches(referee, log.rows)
    last = watches[-1]
    collisions = merge_hits([hit for row in log.rows for hit in row.hits], rules.collision_gap_s)
    reading = read_signs(watches, log.rows, log.header.signs, rules) if "vertical_signs" in suite.elements else None
    faults = _all_faults(last, collisions, reading)
    finished_s = referee.finished_s(last)
    failed = log.ending.status in FAILED
    return Episode(
        scenario=log.header.scenario,
        seed=log.header.seed,
        light_level=log.header.look.light_level,
        status=log.ending.status,
        reason=log.ending.reason,
        sim_time_s=last.now.time_s,
        arrow_s=referee.start_s,
        run_time_s=None if finished_s is None else finished_s - referee.start_s,
        laps_s=referee.laps_s(last),
        parked=last.parked_s is not None if referee.programme.parks else None,
        signs_read=(reading.right, reading.passed) if reading else None,
        distance_m=last.distance_m,
        completion=referee.completion(last),
        localization=_localization(referee, log.rows),
        driving=_driving(referee, watches),
        collisions=collisions,
        faults=faults,
        points=0.0 if failed else _points(referee, last, reading, faults),
        driving_score=0.0 if failed else _driving_score(referee, last, faults),
    )


def _all_faults(last: Watch, collisions: Sequence[Hit], reading: SignReading | None) -> tuple[Fault, ...]:
    hits = [Fault(kind=FaultKind.COLLISION, time_s=hit.time_s, what=hit.with_name) for hit in collisions]
    read = reading.faults if reading else ()
    return tuple(sorted((*last.faults, *hits, *read), key=lambda fault: fault.time_s))


def _watches(referee: Referee, rows: Sequence[Row]) -> list[Watch]:
    moments = (Moment(time_s=row.time_s, pose=row.truth) for row in rows[1:])
    return list(accumulate(moments, referee.step, initial=referee.begin(rows[0].truth)))


def _driving(referee: Referee, watches: Sequence[Watch]) -> Driving:
    last = watches[-1]
    driven = [watch for watch in watches if watch.shown >= 0 and not referee.orders.is_parking(watch)]
    offsets_m = np.array([watch.progress.offset_m for watch in driven])
    waited = last.set_out and not last.count(FaultKind.FALSE_START) and not referee.programme.only_parks
    return Driving(
        cross_track_rmse_m=rms(offsets_m) if offsets_m.size else None,
        cross_track_max_m=float(np.abs(offsets_m).max()) if offsets_m.size else None,
        line_touches=last.count(FaultKind.LINE_TOUCH),
        off_track_s=last.off_track_s,
        wrong_ways=last.count(FaultKind.WRONG_WAY),
        signs_obeyed=last.obeyed + waited,
        signs_shown=last.shown + 1,
    )


def _localization(referee: Referee, rows: Sequence[Row]) -> Localization | None:
    answered = [(row, row.answer) for row in rows if row.answer and row.time_s >= referee.start_s]
    if not answered:
        return None
    covariances = [answer.covariance for _, answer in answered]
    complete = all(covariance is not None for covariance in covariances)
    return localization(
        truth=pose_array([row.truth for row, _ in answered]),
        estimate=pose_array([answer.estimate for _, answer in answered]),
        covariance=np.array(covariances, dtype=np.float64).reshape(-1, 3, 3) if complete else None,
        reckoned=replayed(
            referee.header.start_pose,
            referee.rules.robot,
            [row.encoders for row in rows],
            [row.time_s for row, _ in answered],
        ),
    )


def merge_hits(hits: Sequence[Hit], gap_s: float) -> tuple[Hit, ...]:
    """Return one hit for each unbroken touch of an object: the first time, the sum of the impulses."""
    merged: list[Hit] = []
    latest: dict[str, tuple[int, float]] = {}  # by object: where its last hit stands, and when it was last felt
    for hit in hits:
        index, felt_s = latest.get(hit.with_name, (len(merged), -math.inf))
        if hit.time_s - felt_s > gap_s:
            index = len(merged)
            merged.append(hit)
        else:
            total = merged[index].impulse_ns + hit.impulse_ns
            merged[index] = msgspec.structs.replace(merged[index], impulse_ns=total)
        latest[hit.with_name] = (index, hit.time_s)
    return tuple(merged)


def _points(referee: Referee, last: Watch, reading: SignReading | None, faults: Sequence[Fault]) -> float:
    """Return the points: what is earned, less the prices of all faults, and at least 0."""
    earnings, half_laps = referee.rules.earnings, len(referee.programme.half_laps)
    earned = earnings.half_lap * last.as_ordered
    if half_laps and last.half == half_laps:
        earned += half_laps * earnings.half_lap_par_s - math.fsum(referee.laps_s(last))
    if last.parked_s is not None:
        earned += earnings.parked
    if reading:
        earned += earnings.sign_read * reading.right
    return max(earned - math.fsum(referee.rules.prices.of(fault.kind).points for fault in faults), 0.0)


def _driving_score(referee: Referee, last: Watch, faults: Sequence[Fault]) -> float:
    """Return 100 x completion x the factor of each fault."""
    factors = (referee.rules.prices.of(fault.kind).factor for fault in faults)
    return math.prod(factors, start=100.0 * referee.completion(last))
