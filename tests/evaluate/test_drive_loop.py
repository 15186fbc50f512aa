"""Runs with the real simulator and renderer, short ones."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
from made_runs import MakeSubmission

from adc_bench.errors import InputError
from adc_bench.evaluate.driving import software
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.episode import drive
from adc_bench.evaluate.isolation import AgentProcess
from adc_bench.evaluate.log import EpisodeLog, read_log
from adc_bench.evaluate.plans import plan_for
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.run import evaluate_submission, rescore
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.sandbox import sandbox_fault
from adc_bench.evaluate.score import score
from adc_bench.evaluate.submission import Submission, load_submission
from adc_bench.evaluate.suite import Suite, load_suite, rules_for, rules_id
from adc_bench.evaluate.trace import Driven
from adc_bench.render import ArenaRenderer
from adc_bench.world.salt import salt_sha256


def driven(submission: Submission, suite: Suite, renderer: ArenaRenderer, rules: Rules) -> Driven:
    run = RunId(suite=suite, rules=rules_id(suite, rules), submission=submission.id, software=software("none"))
    plan = plan_for(run, suite.seeds[0], submission, rules)
    with AgentProcess(plan.load, rules.rig, rules.limits) as agent:
        return drive(plan, renderer, agent)


@pytest.mark.parametrize(
    ("factory", "reason", "answers"),
    [
        ("RaisesAtSeven", Reason.STEP_RAISED, 7),
        ("NotFiniteAtTwo", Reason.NOT_FINITE, 2),
        ("HangsAtThree", Reason.STEP_TIMEOUT, 3),
        ("DiesAtFour", Reason.DIED, 4),
        ("RaisesInStart", Reason.START_RAISED, 0),
        ("Still", Reason.TIME_LIMIT, 26),
    ],
)
def test_how_a_run_ends(
    submission_of: MakeSubmission,
    short_suite: Suite,
    renderer: ArenaRenderer,
    hurried: Rules,
    factory: str,
    reason: Reason,
    answers: int,
) -> None:
    run = driven(submission_of(factory), short_suite, renderer, hurried)
    assert run.ending.reason is reason
    assert [row.step for row in run.rows] == list(range(answers + 1))
    assert [row.answer is not None for row in run.rows] == [True] * answers + [False]
    assert len(run.compute_s) >= answers


@pytest.mark.parametrize(("latency_s", "late_steps"), [(0.0, 1), (0.05, 2), (0.12, 4)])
def test_a_command_acts_one_step_late_and_later_by_the_latency(
    submission_of: MakeSubmission,
    short_suite: Suite,
    renderer: ArenaRenderer,
    hurried: Rules,
    latency_s: float,
    late_steps: int,
) -> None:
    """The command to observation 0 acts from step `late_steps` on: the first motion is in the row after it."""
    submission = submission_of("Straight", latency_s=latency_s)
    run = driven(submission, short_suite, renderer, hurried)
    moved = [abs(row.truth.x_m - run.rows[0].truth.x_m) > 1e-3 for row in run.rows]
    assert moved.index(True) == late_steps + 1


def test_the_log_tells_the_run(
    submission_of: MakeSubmission, short_suite: Suite, renderer: ArenaRenderer, hurried: Rules
) -> None:
    submission = submission_of("Straight")
    run = driven(submission, short_suite, renderer, hurried)
    assert [row.panel for row in run.rows] == ["stop"] * 6 + ["up"] * (len(run.rows) - 6)
    assert [row.time_s for row in run.rows] == pytest.approx(np.arange(len(run.rows)) * 0.05)
    ticks = [tick for row in run.rows for tick in row.encoders.left_ticks]
    assert ticks == sorted(ticks) and ticks[-1] > 100
    suite_run = RunId(suite=short_suite, rules=rules_id(short_suite, hurried), submission=submission.id, software={})
    header = plan_for(suite_run, short_suite.seeds[0], submission, hurried).header
    episode = score(EpisodeLog(header=header, rows=run.rows, ending=run.ending), hurried)
    assert episode.driving.signs_obeyed == 0, "it did not wait for the arrow"
    assert episode.localization is not None
    assert episode.localization.dead_reckoning_max_m < 0.05
    assert episode.distance_m == pytest.approx(run.rows[-1].truth.x_m - run.rows[0].truth.x_m, abs=0.01)


def counts(run: Driven) -> np.ndarray:
    """What arrived at each step: times of road picture, panel picture and scan (-1: none), and what was in them."""
    return np.array([row.answer.covariance for row in run.rows if row.answer and row.answer.covariance])


def test_scans_and_pictures_arrive_in_their_turn(
    submission_of: MakeSubmission, short_suite: Suite, renderer: ArenaRenderer, hurried: Rules
) -> None:
    told = counts(driven(submission_of("Counts"), short_suite, renderer, hurried))
    times = 0.05 * np.arange(len(told))
    assert told[:, 0] == pytest.approx(times)
    assert told[:, 1] == pytest.approx(np.where(np.arange(len(told)) % 4 == 0, times, -1.0))
    assert told[:, 2] == pytest.approx(np.where(np.arange(len(told)) % 2 == 0, times, -1.0))
    assert set(told[::2, 4]) == {338.0}
    assert (told[:, 5] == 0).all(), "no semantic camera"


def test_late_cameras_and_objects_in_view(submission_of: MakeSubmission, short_suite: Suite, hurried: Rules) -> None:
    """The road camera is 0.12 s late: three steps. Its objects come with its pictures."""
    replace, rig = msgspec.structs.replace, hurried.rig
    cameras = (replace(rig.camera("road"), latency_s=0.12), rig.camera("panel"))
    rules = replace(hurried, rig=replace(rig, cameras=cameras))
    suite = replace(short_suite, semantic_camera=True, ranked=False)
    with_semantic = ArenaRenderer(rules_for(suite, rules).rig)
    told = counts(driven(submission_of("Counts"), suite, with_semantic, rules))
    steps = np.arange(len(told))
    assert told[:, 0] == pytest.approx(np.where(steps < 3, -1.0, 0.05 * (steps - 3)))
    assert told[:, 1] == pytest.approx(np.where(steps % 4 == 0, 0.05 * steps, -1.0))
    assert (told[:3, 5] == 0).all() and (told[3:, 5] >= 1).all()
    assert told[3:, 6] == pytest.approx(0.65, abs=0.02), "the crosswalk is ahead"


def test_a_folder_is_the_same_twice_resumes_and_rescores(
    submission_of: MakeSubmission, short_suite: Suite, hurried: Rules, tmp_path: Path
) -> None:
    submission, first, second = submission_of("Straight"), tmp_path / "first", tmp_path / "second"
    told: list[int] = []
    result = evaluate_submission(submission, short_suite, first, rules=hurried, tell=told.append)
    assert (result.status, result.planned, result.completed, result.eligible) == ("success", 2, 2, False)
    assert told == [0, 1, 2]
    evaluate_submission(submission, short_suite, second, episodes=1, rules=hurried)
    kept = second / "episodes" / "dev-1.jsonl"
    stamp = kept.stat().st_mtime_ns
    evaluate_submission(submission, short_suite, second, rules=hurried)
    assert kept.stat().st_mtime_ns == stamp, "what is there is not driven again"
    names = ["result.json", "episodes/dev-1.jsonl", "episodes/dev-2.jsonl"]
    assert [(first / name).read_bytes() for name in names] == [(second / name).read_bytes() for name in names]

    kept.write_bytes(kept.read_bytes()[:-40])
    with pytest.raises(InputError, match=r"a damaged episode log: line \d+"):
        rescore(second, hurried)
    with pytest.raises(InputError, match="a damaged episode log"):
        evaluate_submission(submission, short_suite, second, rules=hurried)
    kept.unlink()
    evaluate_submission(submission, short_suite, second, rules=hurried)
    assert [(first / name).read_bytes() for name in names] == [(second / name).read_bytes() for name in names]
    assert rescore(second, hurried) == result
    assert sorted(path.name for path in first.iterdir()) == [
        "episodes",
        "failures",
        "films",
        "logs",
        "paths.png",
        "result.json",
        "timing.json",
    ]
    _refuses_other_runs(submission_of, short_suite, first, hurried)


def _refuses_other_runs(submission_of: MakeSubmission, suite: Suite, folder: Path, rules: Rules) -> None:
    before = (folder / "result.json").read_bytes()
    other = submission_of("Still")
    with pytest.raises(InputError) as caught:
        evaluate_submission(other, suite, folder, rules=rules)
    assert caught.value.found == "the runs of another submission"
    assert "--overwrite" in caught.value.todo
    longer = msgspec.structs.replace(suite, time_limit_s=2.0)
    with pytest.raises(InputError, match="the runs of another suite and rules and submission"):
        evaluate_submission(other, longer, folder, rules=rules)
    assert (folder / "result.json").read_bytes() == before
    result = evaluate_submission(other, suite, folder, episodes=1, overwrite=True, rules=rules)
    assert result.submission.name == "still"
    assert not (folder / "episodes" / "dev-2.jsonl").exists()
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"a folder with notes\.txt"):
        evaluate_submission(other, suite, folder, overwrite=True, rules=rules)
    assert (folder / "notes.txt").exists() and (folder / "result.json").exists()


def test_a_submission_that_cannot_be_loaded_leaves_no_result(
    submission_of: MakeSubmission, short_suite: Suite, hurried: Rules, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="without step"):
        evaluate_submission(submission_of("NoStep"), short_suite, tmp_path / "out", rules=hurried)
    assert not list((tmp_path / "out" / "episodes").iterdir())
    assert not (tmp_path / "out" / "result.json").exists()


AGENT = """
from adc_bench.api import Command

class Reports:
    def start(self, mission):
        self.pose = mission.start_pose
    def step(self, observation):
        sign = "sign_dip" if observation.step == 3 else None
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=self.pose, sign=sign)
"""


@pytest.mark.parametrize(("name", "order"), [("dev-p1", "park"), ("dev-v1", "up")])
def test_the_panels_show_the_orders_and_a_sign_reported_is_in_the_log(
    hurried: Rules, tmp_path: Path, name: str, order: str
) -> None:
    folder = tmp_path / "reports"
    folder.mkdir()
    (folder / "reports.py").write_text(AGENT)
    head = 'name = "reports"\nauthors = ["someone"]\nkind = "driver"\n'
    (folder / "submission.toml").write_text(head + 'entry = "reports:Reports"\n')
    submission = load_submission(str(folder), {})
    suite = msgspec.structs.replace(load_suite(name), start_delay_s=(0.2, 0.2), time_limit_s=0.5)
    result = evaluate_submission(submission, suite, tmp_path / "out", rules=hurried)
    log = read_log(tmp_path / "out" / "episodes" / f"{result.episodes[0].scenario}.jsonl")
    assert [row.panel for row in log.rows[:6]] == ["stop"] * 4 + [order] * 2
    assert [row.answer.sign for row in log.rows if row.answer and row.answer.sign] == ["sign_dip"]
    assert log.rows[3].answer and log.rows[3].answer.sign
    (episode,) = result.episodes
    assert episode.signs_read == (None if name == "dev-p1" else (0, 0))
    assert [fault.what for fault in episode.faults] == ([] if name == "dev-p1" else ["sign_dip"])


def test_a_hidden_suite_is_driven_with_its_salt_which_nothing_tells(
    submission_of: MakeSubmission, short_suite: Suite, hurried: Rules, tmp_path: Path
) -> None:
    salt, submission, out = b"0123456789abcdef", submission_of("Still"), tmp_path / "out"
    hidden = msgspec.structs.replace(short_suite, salt_sha256=salt_sha256(salt))
    with pytest.raises(InputError, match="no salt"):
        evaluate_submission(submission, hidden, out, rules=hurried)
    result = evaluate_submission(submission, hidden, out, episodes=1, rules=hurried, salt=salt)
    assert rescore(out, hurried) == result
    drawn = str(hidden.drawn_seed(hidden.seeds[0], salt)).encode()
    written = [path.read_bytes() for path in out.rglob("*") if path.is_file()]
    assert written and not any(secret in data for data in written for secret in (salt, drawn))


def test_one_bad_run_leaves_the_others(
    submission_of: MakeSubmission, short_suite: Suite, hurried: Rules, tmp_path: Path
) -> None:
    result = evaluate_submission(submission_of("RaisesAtSeven"), short_suite, tmp_path / "out", rules=hurried)
    assert [episode.status for episode in result.episodes] == ["agent-failed", "agent-failed"]
    assert (result.status, result.completed) == ("success", 2)
    log = (tmp_path / "out" / "episodes" / "dev-2.jsonl").read_text()
    assert "ValueError: seven is too much" in log.splitlines()[-1]
    assert all(math.isfinite(figure.mean) for figure in result.summary.values())


def test_a_slow_agent_is_driven_to_the_end_and_its_latency_told(
    submission_of: MakeSubmission, short_suite: Suite, hurried: Rules, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    evaluate_submission(submission_of("Slow"), short_suite, out, episodes=1, rules=hurried)
    timing = msgspec.json.decode((out / "timing.json").read_bytes())
    assert timing["latency"]["verdict"] == "exceeded"
    assert timing["latency"]["allowed_s"] == 0.05
    assert timing["isolation"] == ("none" if sandbox_fault() else "bubblewrap")
