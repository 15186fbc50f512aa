"""Small suites of recordings, submissions of `recorded_agents.py`, and logs of runs over recordings made by hand."""

import shutil
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from adc_bench.api import Detection, Kind
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.log import DetectionLog, LocalizationLog
from adc_bench.evaluate.recorded_log import (
    DetectionHeader,
    DetectionRow,
    Encoders,
    LocalizationHeader,
    LocalizationRow,
    Located,
)
from adc_bench.evaluate.recorded_suite import DetectionSuite, LocalizationSuite
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.submission import Submission, SubmissionId, load_submission
from adc_bench.evaluate.suite import load_suite, rules_id
from adc_bench.geometry import Pose2
from adc_bench.world.frame import NO_KEYPOINTS, Label
from adc_bench.world.sensors import SensorRig

TOML = 'name = "{}"\nauthors = ["someone"]\nkind = "{}"\nentry = "recorded_agents:{}"\n'
CAMERA = (0.0, 0.0, 0.7, -0.5, 0.5, -0.5, 0.5)  # looks along +x


def recorded_submission(folder: Path, kind: Kind, factory: str) -> Submission:
    """Make a folder whose submission is one of `recorded_agents.py`."""
    folder.mkdir(exist_ok=True)
    shutil.copy(Path(__file__).parent / "recorded_agents.py", folder)
    (folder / "submission.toml").write_text(TOML.format(factory.lower(), kind, factory))
    return load_submission(str(folder), {})


def short_drives(seconds: float, count: int) -> LocalizationSuite:
    """Return the suite dev-loc with so many drives, so long."""
    suite = load_suite("dev-loc")
    assert isinstance(suite, LocalizationSuite)
    drives = msgspec.structs.replace(suite.split.drives, duration_s=(seconds, seconds), count=count)
    return msgspec.structs.replace(suite, split=msgspec.structs.replace(suite.split, drives=drives))


def few_pictures(pictures: int, runs: int) -> DetectionSuite:
    """Return the suite dev-det with so many runs of so many pictures."""
    suite = load_suite("dev-det")
    assert isinstance(suite, DetectionSuite)
    split = msgspec.structs.replace(suite.split, frames=pictures * runs, frames_per_scenario=pictures)
    return msgspec.structs.replace(suite, pictures=pictures, split=split)


def run_of(suite: LocalizationSuite | DetectionSuite, name: str) -> RunId:
    submission = SubmissionId(
        name=name, authors=("someone",), kind=suite.kind, sha256="0" * 64, latency_s=0.0, options={}
    )
    return RunId(suite=suite, rules=rules_id(suite), submission=submission, software={"adc_bench": "0"})


def straight_log(
    suite: LocalizationSuite,
    name: str,
    seed: int,
    error_m: float,
    *,
    sigma_m: float | None = 0.02,
    reason: Reason = Reason.FINISHED,
    steps: int = 40,
) -> LocalizationLog:
    """Return a drive of 0.05 m a step straight on, whose estimates are off to the left."""
    scenario, plan = suite.drawn(seed, SensorRig(), None)
    start = Pose2(x_m=-4.0, y_m=-2.6, yaw_rad=0.0)
    header = LocalizationHeader(
        run=run_of(suite, name),
        scenario=suite.scenario_name(seed),
        seed=seed,
        look=scenario.look,
        start_pose=start,
        mission=plan.script.mission,
        behaviour=plan.script.behaviour,
    )
    covariance = None if sigma_m is None else tuple(np.diag(np.square([sigma_m, sigma_m, 0.01])).ravel().tolist())
    rows = []
    for step in range(steps):
        truth = start @ Pose2(x_m=0.05 * step, y_m=0.0, yaw_rad=0.0)
        located = Located(estimate=truth @ Pose2(x_m=0.0, y_m=error_m, yaw_rad=0.0), covariance=covariance)
        time_s = 0.05 * step
        encoders = Encoders(time_s=(time_s,), left_ticks=(40 * step,), right_ticks=(40 * step,))
        rows.append(LocalizationRow(step=step, time_s=time_s, truth=truth, encoders=encoders, answer=located))
    return LocalizationLog(header=header, rows=tuple(rows), ending=Ending(reason=reason))


def label(category_id: int, box: Sequence[float], corners: bool = True) -> Label:
    left, top, right, bottom = box
    points = ((left, top), (right, top), (right, bottom), (left, bottom))
    return Label(
        category_id=category_id,
        instance="thing",
        box_px=(left, top, right, bottom),
        amodal_box_px=(left, top, right, bottom),
        amodal_box_whole_px=(left, top, right, bottom),
        mask_rle=b"",
        visible_px=100,
        visible_fraction=1.0,
        truncation=0.0,
        distance_m=2.0,
        pose_world_object=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        keypoints_px=tuple((u, v, 2) for u, v in points) if corners else NO_KEYPOINTS,
        ignore=False,
    )


def pictures_log(
    suite: DetectionSuite,
    name: str,
    seed: int,
    labels: Sequence[Sequence[Label]],
    answers: Sequence[Sequence[Detection]],
    reason: Reason = Reason.FINISHED,
) -> DetectionLog:
    """Return a set of pictures with these labels and answers."""
    header = DetectionHeader(run=run_of(suite, name), scenario=suite.scenario_name(seed), seed=seed)
    rows = [
        DetectionRow(
            step=step,
            time_s=0.05 * step,
            camera="road",
            pose_world_camera=CAMERA,
            labels=tuple(of_picture),
            answer=tuple(answer),
        )
        for step, (of_picture, answer) in enumerate(zip(labels, answers, strict=True))
    ]
    return DetectionLog(header=header, rows=tuple(rows), ending=Ending(reason=reason))
