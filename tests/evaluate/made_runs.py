"""Runs made by hand: true poses along given paths, in logs like those of a drive."""

from collections.abc import Callable, Sequence

import numpy as np

from adc_bench.evaluate.course_progress import Moment
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.log import Drive, Encoders, EpisodeLog, Header, Hit, Row, RunId
from adc_bench.evaluate.referee import Referee, Watch
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.submission import Submission, SubmissionId
from adc_bench.evaluate.suite import Suite, load_suite, mission_for, rules_id, scenario_for, start_step
from adc_bench.geometry import Pose2
from adc_bench.world.course import Course

COURSE = Course(spec=RULES.course)
PERIOD_S = RULES.control_period_s
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
        wheel_separation_m=scenario.robot_truth.wheel_separation_m,
    )


def referee_of(header: Header) -> Referee:
    return Referee(course=COURSE, rules=RULES, header=header)


def along_lap(header: Header, speed_mps: float, left_m: float = 0.0, *, wait_s: float = 0.0) -> PoseAt:
    """Return the pose at a time of a robot that leaves `wait_s` after the arrow and keeps to a line beside the lane."""
    leaves_s = header.start_step * PERIOD_S + wait_s

    def pose(time_s: float) -> Pose2:
        s_m = RULES.start_x_m + speed_mps * max(time_s - leaves_s, 0.0)
        return COURSE.lap.pose(s_m) @ Pose2(x_m=0.0, y_m=left_m, yaw_rad=0.0)

    return pose


def watch_run(header: Header, pose_at: PoseAt, longest_s: float = 300.0) -> tuple[list[Moment], Watch, Reason]:
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


def log_of(header: Header, pose_at: PoseAt, hits: Sequence[Hit] = (), error_m: float = 0.02) -> EpisodeLog:
    """Return the log of a run whose estimates lie `error_m` ahead of the truth, with still encoders."""
    moments, _, reason = watch_run(header, pose_at)
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
            ),
        )
        for step, moment in enumerate(moments)
    ]
    return EpisodeLog(header=header, rows=tuple(rows), ending=Ending(reason=reason))
