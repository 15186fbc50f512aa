"""A run's score: a pure function of its log."""

import math
from collections.abc import Sequence
from itertools import accumulate

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.evaluate.course_progress import Moment
from adc_bench.evaluate.ending import Reason, Status
from adc_bench.evaluate.log import EpisodeLog, Header, Hit, Row
from adc_bench.evaluate.metrics import Localization, dead_reckoning, localization, rms
from adc_bench.evaluate.referee import Referee, Watch
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.suite import rules_for
from adc_bench.geometry import Pose2
from adc_bench.world.course import Course


class Driving(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the run was driven. `off_track_s`: time with a wheel beyond the middle of the road's edge line.

    The only sign shown is the arrow; it is obeyed by a robot that waits for it and then sets out. Cross-track errors
    are against the right lane's centre from the arrow on (none for a run that ended before it).
    """

    cross_track_rmse_m: float | None
    cross_track_max_m: float | None
    line_touches: int
    off_track_s: float
    wrong_ways: int
    signs_obeyed: int
    signs_shown: int


class Episode(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The score of one run."""

    scenario: str
    seed: int
    light_level: str
    status: Status
    reason: Reason
    sim_time_s: float
    arrow_s: float
    run_time_s: float | None  # from the arrow to the last crossing; none if not all laps were driven
    laps_s: tuple[float, ...]
    distance_m: float
    completion: float
    localization: Localization | None  # none if there is no estimate after the arrow
    driving: Driving
    collisions: tuple[Hit, ...]
    points: float
    driving_score: float


def score(log: EpisodeLog, rules: Rules = RULES) -> Episode:
    """Return the score of a run."""
    rules = rules_for(log.header.run.suite, rules)
    referee = Referee(course=Course(spec=rules.course), rules=rules, header=log.header)
    watches = _watches(referee, log.rows)
    last, laps_s = watches[-1], referee.laps_s(watches[-1])
    driving = _driving(referee, watches)
    collisions = merge_hits([hit for row in log.rows for hit in row.hits], rules.collision_gap_s)
    finished = len(laps_s) >= log.header.run.suite.laps
    return Episode(
        scenario=log.header.scenario,
        seed=log.header.seed,
        light_level=log.header.look.light_level,
        status=log.ending.status,
        reason=log.ending.reason,
        sim_time_s=last.now.time_s,
        arrow_s=referee.arrow_s,
        run_time_s=math.fsum(laps_s) if finished else None,
        laps_s=laps_s,
        distance_m=last.distance_m,
        completion=referee.completion(last),
        localization=_localization(referee, log.rows),
        driving=driving,
        collisions=collisions,
        points=_points(referee, last, len(collisions), math.fsum(laps_s) if finished else None),
        driving_score=_driving_score(referee, last, len(collisions)),
    )


def _watches(referee: Referee, rows: Sequence[Row]) -> list[Watch]:
    moments = (Moment(time_s=row.time_s, pose=row.truth) for row in rows[1:])
    return list(accumulate(moments, referee.step, initial=referee.begin(rows[0].truth)))


def _driving(referee: Referee, watches: Sequence[Watch]) -> Driving:
    last = watches[-1]
    offsets_m = np.array([w.progress.offset_m for w in watches if w.now.time_s >= referee.arrow_s])
    return Driving(
        cross_track_rmse_m=rms(offsets_m) if offsets_m.size else None,
        cross_track_max_m=float(np.abs(offsets_m).max()) if offsets_m.size else None,
        line_touches=last.line_touches,
        off_track_s=last.off_track_s,
        wrong_ways=last.wrong_ways,
        signs_obeyed=int(last.set_out and not last.false_start),
        signs_shown=int(last.now.time_s >= referee.arrow_s),
    )


def _localization(referee: Referee, rows: Sequence[Row]) -> Localization | None:
    answered = [(row, row.answer) for row in rows if row.answer and row.time_s >= referee.arrow_s]
    if not answered:
        return None
    covariances = [answer.covariance for _, answer in answered]
    complete = all(covariance is not None for covariance in covariances)
    return localization(
        truth=_array([row.truth for row, _ in answered]),
        estimate=_array([answer.estimate for _, answer in answered]),
        covariance=np.array(covariances, dtype=np.float64).reshape(-1, 3, 3) if complete else None,
        reckoned=replayed(referee.header, rows, [row.time_s for row, _ in answered], referee.rules),
    )


def replayed(
    header: Header, rows: Sequence[Row], times_s: Sequence[float], rules: Rules = RULES
) -> NDArray[np.float64]:
    """Return where dead reckoning from a run's own encoders would be at these times, (n, 2)."""
    return dead_reckoning(
        header.start_pose,
        rules_for(header.run.suite, rules).robot,
        np.array([time_s for row in rows for time_s in row.encoders.time_s]),
        np.array([ticks for row in rows for ticks in row.encoders.left_ticks], dtype=np.float64),
        np.array([ticks for row in rows for ticks in row.encoders.right_ticks], dtype=np.float64),
        np.array(times_s),
    )


def _array(poses: Sequence[Pose2]) -> NDArray[np.float64]:
    return np.array([(pose.x_m, pose.y_m, pose.yaw_rad) for pose in poses], dtype=np.float64).reshape(-1, 3)


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


def _points(referee: Referee, last: Watch, collisions: int, run_time_s: float | None) -> float:
    """Return the points by the published formula, generalised to any number of laps."""
    points = referee.rules.points
    earned = points.half_lap * referee.half_laps(last)
    if run_time_s is not None:
        earned += 2 * referee.header.run.suite.laps * points.half_lap_par_s - run_time_s
    lost = (
        points.line_touch * last.line_touches
        + points.off_road * last.off_road
        + points.false_start * last.false_start
        + points.wrong_way * last.wrong_ways
        + points.collision * collisions
    )
    return max(earned - lost, 0.0)


def _driving_score(referee: Referee, last: Watch, collisions: int) -> float:
    factors = referee.rules.factors
    return (
        100.0
        * referee.completion(last)
        * factors.line_touch**last.line_touches
        * factors.off_road**last.off_road
        * factors.false_start**last.false_start
        * factors.wrong_way**last.wrong_ways
        * factors.collision**collisions
    )
