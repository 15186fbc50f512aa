"""Localisers and detectors over recordings: what they are told, how they end, and that the bytes are the same."""

import json
import os
import random
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from made_recordings import few_pictures, recorded_submission, short_drives
from test_driven_suites import evaluating
from test_equal_results import scored

from adc_bench.api import Kind
from adc_bench.cli.main import main
from adc_bench.errors import InputError
from adc_bench.evaluate.driving import driven_by, software
from adc_bench.evaluate.ending import STATUS_OF, Ending, Reason
from adc_bench.evaluate.isolation import AgentProcess
from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.localization_score import LocalizationEpisode
from adc_bench.evaluate.plans import any_plan_for
from adc_bench.evaluate.recorded_log import DetectionRow, LocalizationRow
from adc_bench.evaluate.recording import AtHand, drive_in, shard_of
from adc_bench.evaluate.replay import ReplayPlan
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.run import evaluate_submission, rescore
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.submission import Submission
from adc_bench.evaluate.suite import AnySuite, rules_id
from adc_bench.generate import render_split
from adc_bench.generate.drives import simulate
from adc_bench.world.sensors import SensorRig

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "wheel_localizer"
DRIVES, PICTURES = short_drives(1.0, 2), few_pictures(4, 2)
SUITES: dict[Kind, AnySuite] = {"localizer": DRIVES, "detector": PICTURES}
Make = Callable[[Kind, str], Submission]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    return lambda kind, factory: recorded_submission(tmp_path / factory.lower(), kind, factory)


@pytest.fixture(scope="module")
def hasty() -> Rules:
    return msgspec.structs.replace(RULES, limits=Limits(load_s=60.0, start_s=20.0, step_s=5.0))


def plan_of(submission: Submission, rules: Rules = RULES) -> ReplayPlan:
    suite = SUITES[submission.id.kind]
    run = RunId(suite=suite, rules=rules_id(suite, rules), submission=submission.id, software=software("none"))
    plan = any_plan_for(run, suite.seeds[0], submission, rules)
    assert isinstance(plan, ReplayPlan)
    return plan


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> dict[Kind, AtHand]:
    """The first recording of each suite, made once."""
    found: dict[Kind, AtHand] = {}
    for kind, factory in (("localizer", "Located"), ("detector", "Finder")):
        folder = tmp_path_factory.mktemp(kind)
        with shard_of(plan_of(recorded_submission(folder / "agent", kind, factory)).source) as (store, name, shard):
            (folder / name).write_bytes(store.read(name))
            found[kind] = AtHand(root=str(folder), file=name, frames=len(shard))
    return found


def test_what_a_localiser_is_told_is_what_arrived_at_each_step(sources: dict[Kind, AtHand]) -> None:
    """The simulation itself says what arrived: it is driven once more."""
    scenario, plan = DRIVES.drawn(DRIVES.seeds[0], SensorRig(), None)
    rows, shown = simulate(scenario, plan).rows, drive_in(sources["localizer"])
    assert len(shown) == len(rows) == 20
    for row, each in zip(rows, shown, strict=True):
        sensed, readings = each.sensed, row.readings
        assert (sensed.step, sensed.time_s) == (row.step, row.time_s)
        assert np.array_equal(sensed.encoders.left_ticks, readings.encoders.left_ticks)
        assert np.array_equal(sensed.encoders.time_s, readings.encoders.time_s)
        assert np.array_equal(sensed.imu.yaw_rate_radps, readings.imu.yaw_rate_radps)
        assert (sensed.laser is None) == (readings.laser is None)
        if sensed.laser and readings.laser:
            assert np.allclose(sensed.laser.ranges_m, readings.laser.ranges_m, atol=1e-5)
        assert isinstance(each.row, LocalizationRow)
        place = row.pose_world_robot.translation_m
        assert np.allclose((each.row.truth.x_m, each.row.truth.y_m), place[:2], atol=1e-12)
    mounts = {mount.name: mount for mount in SensorRig().cameras}
    for name, mount in mounts.items():
        late_steps = round(mount.latency_s / 0.05 + 0.499)
        came = [each.sensed.step for each in shown if name in each.sensed.pictures]
        assert came == list(range(late_steps, 20, mount.period_steps))


@pytest.mark.parametrize(("kind", "factory"), [("localizer", "LocatedRaises"), ("detector", "FinderRaises")])
def test_bytes_are_equal_however_a_run_is_done(
    make: Make, hasty: Rules, tmp_path: Path, kind: Kind, factory: str
) -> None:
    submission, suite = make(kind, factory), SUITES[kind]
    evaluate_submission(submission, suite, tmp_path / "plain", rules=hasty)
    evaluate_submission(submission, suite, tmp_path / "two", rules=hasty, workers=2)
    plain = scored(tmp_path / "plain")
    assert scored(tmp_path / "two") == plain
    first, second = sorted((tmp_path / "two" / "episodes").iterdir())
    first.unlink()
    second.write_bytes(second.read_bytes()[:-9])
    with pytest.raises(InputError, match="a damaged episode log"):
        evaluate_submission(submission, suite, tmp_path / "two", rules=hasty)
    second.unlink()
    evaluate_submission(submission, suite, tmp_path / "two", episodes=1, rules=hasty)
    result = evaluate_submission(submission, suite, tmp_path / "two", rules=hasty, in_process=True)
    assert scored(tmp_path / "two") == plain
    assert rescore(tmp_path / "two", hasty) == result
    assert {(run.status, run.reason) for run in result.episodes} == {("agent-failed", Reason.STEP_RAISED)}
    assert (result.status, result.completed, result.eligible) == ("success", 2, False)
    assert any(name.startswith("failures/") and name.endswith(".jpg") for name in plain)


def ending_of(submission: Submission, sources: dict[Kind, AtHand], rules: Rules) -> tuple[Ending, list[bool]]:
    plan = plan_of(submission, rules)
    at_hand = ReplayPlan(
        header=plan.header,
        source=sources[submission.id.kind],
        mission=plan.mission,
        load=plan.load,
        rules=plan.rules,
    )
    with AgentProcess(plan.load, rules.rig, rules.limits) as agent:
        driven = driven_by(at_hand, agent)
    return driven.ending, [row.answer is not None for row in driven.rows]


@pytest.mark.parametrize(
    ("kind", "factory", "reason", "detail"),
    [
        ("localizer", "LocatedRaises", Reason.STEP_RAISED, "ValueError: lost"),
        ("localizer", "LocatedNan", Reason.NOT_FINITE, "x_m=nan"),
        ("localizer", "LocatedWrongShape", Reason.NOT_A_COMMAND, "`array` of length 9"),
        ("localizer", "LocatedDies", Reason.DIED, "exit status 7"),
        ("localizer", "LocatedSleeps", Reason.STEP_TIMEOUT, "no answer within 2 s"),
        ("detector", "FinderRaises", Reason.STEP_RAISED, "ValueError: blind"),
        ("detector", "FinderNan", Reason.NOT_FINITE, "score=nan"),
        ("detector", "FinderNanCorner", Reason.NOT_FINITE, "inf"),
        ("detector", "FinderHuge", Reason.OUT_OF_RANGE, "1e+300"),
        ("detector", "FinderTooSure", Reason.OUT_OF_RANGE, "score=1.5"),
        ("detector", "FinderTooMany", Reason.OUT_OF_RANGE, "101 detections on one picture; at most 100"),
        ("detector", "FinderWrongShape", Reason.NOT_DETECTIONS, "`array` of length 4"),
        ("detector", "FinderUnknownCategory", Reason.NOT_DETECTIONS, "Invalid enum value 'tree'"),
        ("detector", "FinderNoList", Reason.NOT_DETECTIONS, "NoneType in place of a list of Detections"),
        ("detector", "FinderOfTuples", Reason.NOT_DETECTIONS, "tuple in place of a Detection"),
        ("detector", "FinderSleeps", Reason.STEP_TIMEOUT, "no answer within 2 s"),
    ],
)
def test_how_a_hostile_one_ends(
    make: Make, sources: dict[Kind, AtHand], kind: Kind, factory: str, reason: Reason, detail: str
) -> None:
    step_s = 2.0 if reason is Reason.STEP_TIMEOUT else 60.0
    rules = msgspec.structs.replace(RULES, limits=Limits(step_s=step_s))
    ending, answered = ending_of(make(kind, factory), sources, rules)
    assert ending.reason is reason, ending
    assert detail in ending.detail
    assert STATUS_OF[reason] in ("agent-failed", "invalid")
    assert answered[:3] == [True, True, False] and not any(answered[2:]), "what follows is logged without an answer"


@pytest.mark.parametrize(("kind", "factory"), [("localizer", "Sure"), ("detector", "Finder")])
def test_a_sound_one_answers_to_the_end(make: Make, sources: dict[Kind, AtHand], kind: Kind, factory: str) -> None:
    ending, answered = ending_of(make(kind, factory), sources, RULES)
    assert ending.reason is Reason.FINISHED and all(answered)


def test_pictures_come_with_their_labels(sources: dict[Kind, AtHand], make: Make) -> None:
    plan = plan_of(make("detector", "Finder"))
    with AgentProcess(plan.load, RULES.rig, RULES.limits) as agent:
        at_hand = ReplayPlan(
            header=plan.header, source=sources["detector"], mission=plan.mission, load=plan.load, rules=plan.rules
        )
        rows = driven_by(at_hand, agent).rows
    assert len(rows) == PICTURES.pictures
    assert all(isinstance(row, DetectionRow) and row.answer is not None for row in rows)
    labels = [label for row in rows for label in row.labels]
    assert labels and all(label.mask_rle == b"" for label in labels)


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as done:
        main(words)
    told = capsys.readouterr()
    return int(done.value.code or 0), told.out, told.err


def test_a_folder_of_drives_says_what_the_suite_says(
    make: Make, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    submission, data, out = make("localizer", "Sure"), tmp_path / "drives", tmp_path / "errors.json"
    render_split(DRIVES.split, data, kind="drives")
    folder = str(submission.load.folder)
    code, told, _ = run(
        capsys, "evaluate", "localization", folder, "--data", str(data), "--out", str(out), "--in-process"
    )
    assert code == 0 and "speed (sloppy), normal" in told
    found = json.loads(out.read_text())
    assert (found["status"], found["eligible"], found["completed"]) == ("success", False, 2)
    suite = evaluate_submission(submission, DRIVES, tmp_path / "suite", in_process=True)
    runs = [msgspec.json.decode(json.dumps(each), type=LocalizationEpisode) for each in found["episodes"]]
    assert tuple(runs) == suite.episodes
    code, _, told = run(capsys, "evaluate", "localization", "reference", "--data", str(tmp_path), "--out", str(out))
    assert code == 3 and "a dataset folder with dataset.toml" in told
    make("detector", "Finder")
    finder = str(tmp_path / "finder")
    code, _, told = run(capsys, "evaluate", "localization", finder, "--data", str(data), "--out", str(out))
    assert code == 3 and "kind = 'localizer', which this suite is for" in told


@pytest.mark.parametrize(
    ("kind", "factory", "code", "lines"),
    [
        ("localizer", "Sure", 0, ["ok     answers     60 steps, then finished", "ok     repeats"]),
        ("detector", "Finder", 0, ["ok     answers     12 steps, then finished", "ok     repeats"]),
        ("detector", "Sure", 3, ["FAULT  loads       Sure without detect", "detect(rgb) -> list of Detection"]),
        ("detector", "FinderOfTuples", 3, ["FAULT  answers     invalid (not-detections) at step 2: tuple in place"]),
    ],
)
def test_validate_knows_every_kind(
    make: Make, capsys: pytest.CaptureFixture[str], kind: Kind, factory: str, code: int, lines: list[str]
) -> None:
    found, told, _ = run(capsys, "validate", str(make(kind, factory).load.folder))
    assert found == code, told
    for line in lines:
        assert line in told


@pytest.mark.slow
def test_runs_over_recordings_killed_again_and_again_go_on_to_the_same_bytes(tmp_path: Path) -> None:
    suite, out, whole = tmp_path / "four.toml", tmp_path / "out", tmp_path / "whole"
    text = (ROOT / "splits" / "suites" / "dev-loc.toml").read_text()
    suite.write_text(text.replace("count = 1\n", "count = 4\n").replace("[10.0, 10.0]", "[3.0, 3.0]"))
    subprocess.run(evaluating(EXAMPLE, suite, whole), check=True)
    chance = random.Random(time.time_ns())
    for _ in range(3):
        process = subprocess.Popen(evaluating(EXAMPLE, suite, out, "--workers", "2"), start_new_session=True)
        time.sleep(chance.uniform(5.0, 20.0))
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    subprocess.run(evaluating(EXAMPLE, suite, out, "--workers", "2"), check=True)
    assert scored(out) == scored(whole)
