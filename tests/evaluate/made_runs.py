"""Runs made by hand: true poses along given paths, in logs like those of a drive."""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache

import numpy as np

from adc_bench.evaluate.course_progress import Moment
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.log import Drive, EpisodeLog, Header, Hit, Row
from adc_bench.evaluate.programme import Programme
from adc_bench.evaluate.recorded_log import Encoders
from adc_bench.evaluate.referee import Referee
from adc_bench.evaluate.referee_watch import Watch
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.submission import Submission, SubmissionId
from adc_bench.evaluate.suite import Suite, load_suite, mission_for, rules_id, scenario_for, start_step
from adc_bench.geometry import Path, Pose2, line
from adc_bench.world.categories import PanelSign, SignCategory
from adc_bench.world.course import Course
from adc_bench.world.route import half_lap

COURSE = Course(spec=RULES.course)
PERIOD_S = RULES.control_period_s
START_X_M = -0.65
LEAD_M = 10.0
PoseAt = Callable[[float], Pose2]
MakeSubmission = Callable[..., Submission]


def header_of(suite: Suite | None = None, seed: int | None = None, name: str = "made") -> Header:
    suite = suite or load_suite("d1")
    seed = suite.seeds[0] if seed is None else seed
    scenario = scenario_for(suite, seed)
    submission = SubmissionId(
        name=name, authors=("someone",), kind="driver", sha256="0" * 64, latency_s=0.0, options={}
    )
    run = RunId(suite=suite, rules=rules_id(suite), submission=submission, software={"adc_bench": "0"})
    return Header(
        run=run,
        scenario=scenario.name,
        seed=seed,
        look=scenario.look,
        start_pose=mission_for(suite, latency_s=0.0, options={}).start_pose,
        start_step=start_step(suite, seed),
        orders=suite.trial(seed).orders,
        layout=scenario.layout,
        signs=scenario.signs,
        wheel_separation_m=scenario.robot_truth.wheel_separation_m,
    )


def referee_of(header: Header) -> Referee:
    return Referee(course=COURSE, rules=RULES, header=header)


@lru_cache
def route_path(orders: tuple[PanelSign, ...]) -> Path:
    """Return the right-hand lane through all half laps that the orders ask for, with straights before and behind."""
    pieces = [piece for half in Programme(orders=orders).half_laps for piece in half_lap(COURSE, half.loop, half.way)]
    start = Pose2(x_m=-LEAD_M, y_m=-COURSE.spec.lane_outer_radius_m, yaw_rad=0.0)
    return Path(start=start, pieces=(line(LEAD_M), *pieces, line(3.0)))


def crosswalks_m(orders: tuple[PanelSign, ...]) -> list[float]:
    """Return the arc lengths, from the first crosswalk, at which the route passes a crosswalk again."""
    halves = Programme(orders=orders).half_laps
    lengths = [sum(piece.length_m for piece in half_lap(COURSE, half.loop, half.way)) for half in halves]
    return np.cumsum(lengths).tolist()


def along(
    header: Header,
    speed_mps: float,
    *,
    orders: tuple[PanelSign, ...] | None = None,
    left_m: Callable[[float], float] = lambda s_m: 0.0,
    wait_s: float = 0.0,
    halts: Mapping[float, float] = {},
) -> PoseAt:
    """Return the pose at a time of a robot that leaves `wait_s` after the start and keeps to the route of these orders
    (the header's own if none), `left_m` beside the lane, and halts at arc lengths for so many seconds.
    """
    path, start_m = route_path(orders or header.orders), header.run.suite.start_x_m
    leaves_s = header.start_step * PERIOD_S + wait_s

    def pose(time_s: float) -> Pose2:
        driven_s = max(time_s - leaves_s, 0.0)
        for at_m, halt_s in sorted(halts.items()):
            arrives_s = (at_m - start_m) / speed_mps
            driven_s = driven_s if driven_s < arrives_s else max(arrives_s, driven_s - halt_s)
        s_m = start_m + speed_mps * driven_s
        return path.pose(s_m + LEAD_M) @ Pose2(x_m=0.0, y_m=left_m(s_m), yaw_rad=0.0)

    return pose


def along_lap(header: Header, speed_mps: float, left_m: float = 0.0, *, wait_s: float = 0.0) -> PoseAt:
    """Return the pose at a time of a robot that keeps to a line beside the lane, and halts nowhere."""
    return along(header, speed_mps, left_m=lambda s_m: left_m, wait_s=wait_s)


def watch_run(header: Header, pose_at: PoseAt, longest_s: float = 400.0) -> tuple[list[Moment], Watch, Reason]:
    """Return the moments, the last watch and the reason of a run with these true poses."""
    referee = referee_of(header)
    moments = [Moment(time_s=0.0, pose=pose_at(0.0))]
    watch = referee.begin(moments[0].pose)
    while (reason := referee.end(watch)) is None:
        time_s = round(len(moments) * PERIOD_S, 9)
        assert time_s < longest_s, "the run never ended"
        moments.append(Moment(time_s=time_s, pose=pose_at(time_s)))
        watch = referee.step(watch, moments[-1])
    return moments, watch, reason


def log_of(
    header: Header,
    pose_at: PoseAt,
    hits: Sequence[Hit] = (),
    error_m: float = 0.02,
    reports: Mapping[float, SignCategory] = {},
) -> EpisodeLog:
    """Return the log of a run whose estimates lie `error_m` ahead of the truth, with still encoders; `reports` are the
    vertical signs reported at times.
    """
    moments, _, reason = watch_run(header, pose_at)
    told = {round(time_s / PERIOD_S): sign for time_s, sign in reports.items()}
    rows = [
        Row(
            step=step,
            time_s=moment.time_s,
            truth=moment.pose,
            v_mps=0.0,
            omega_radps=0.0,
            panel="stop" if step < header.start_step else "up",
            encoders=Encoders(time_s=(moment.time_s,), left_ticks=(0,), right_ticks=(0,)),
            hits=tuple(hit for hit in hits if moment.time_s - PERIOD_S < hit.time_s <= moment.time_s),
            answer=None
            if step == len(moments) - 1
            else Drive(
                v_mps=1.0,
                omega_radps=0.0,
                estimate=moment.pose @ Pose2(x_m=error_m, y_m=0.0, yaw_rad=0.0),
                covariance=tuple(np.diag([error_m**2, 1.0, 1.0]).ravel().tolist()),
                sign=told.get(step),
            ),
        )
        for step, moment in enumerate(moments)
    ]
    return EpisodeLog(header=header, rows=tuple(rows), ending=Ending(reason=reason))
