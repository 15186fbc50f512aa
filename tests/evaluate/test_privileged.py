"""Built-in drivers that are lent a layer of truth, and everyone else, who is not."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from made_runs import MakeSubmission

from adc_bench.cli.main import main
from adc_bench.dataset.layout import to_toml
from adc_bench.errors import InputError, UsageError
from adc_bench.evaluate.driving import agent_side, software
from adc_bench.evaluate.episode import drive
from adc_bench.evaluate.plans import plan_for
from adc_bench.evaluate.results import Timing
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.run import evaluate_submission
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import Suite, rules_for, rules_id
from adc_bench.evaluate.trace import Driven
from adc_bench.evaluate.witness import Privilege, Witness
from adc_bench.leaderboard.records import title
from adc_bench.render import ArenaRenderer


@pytest.fixture(scope="module")
def setting_out(short_suite: Suite) -> Suite:
    """Long enough to see the arrow and drive a metre."""
    return msgspec.structs.replace(short_suite, time_limit_s=1.6, seeds=(1,))


def driven(suite: Suite, renderer: ArenaRenderer, privileged: Privilege, options: dict[str, str]) -> Driven:
    submission = load_submission("thesis", options, privileged)
    rules: Rules = rules_for(suite, RULES)
    run = RunId(suite=suite, rules=rules_id(suite, rules), submission=submission.id, software=software("none"))
    plan, witness = plan_for(run, suite.seeds[0], submission, rules), Witness(privileged)
    with agent_side(plan.load, rules, in_process=True, witness=witness) as agent:
        return drive(plan, renderer, agent, witness)


def test_lent_the_pose_it_is_where_it_believes(setting_out: Suite, renderer: ArenaRenderer) -> None:
    run = driven(setting_out, renderer, "pose", {})
    answered = [row for row in run.rows if row.answer]
    assert answered[-1].truth.x_m - answered[0].truth.x_m > 0.3
    assert all(row.answer and row.answer.estimate == row.truth for row in answered)


def test_lent_detections_it_sets_out_without_weights(
    setting_out: Suite, renderer: ArenaRenderer, tmp_path: Path
) -> None:
    """The file of weights is no such thing: the driver's own detector would refuse it."""
    nothing = tmp_path / "weights"
    nothing.write_bytes(b"")
    run = driven(setting_out, renderer, "detections", {"weights": str(nothing)})
    answered = [row for row in run.rows if row.answer]
    moving = [row.step for row in answered if row.answer and row.answer.v_mps > 0]
    arrow = next(row.step for row in answered if row.panel == "up")
    assert arrow < moving[0] <= arrow + 8  # two pictures of the panel camera
    estimates = np.array([(row.answer.estimate.x_m, row.truth.x_m) for row in answered if row.answer])
    assert 0.0 < np.abs(estimates[:, 0] - estimates[:, 1]).max() < 0.05


def test_the_result_tells_it_and_is_not_eligible(setting_out: Suite, tmp_path: Path) -> None:
    ranked = msgspec.structs.replace(setting_out, ranked=True, time_limit_s=0.5)
    privileged = load_submission("thesis", {}, "pose")
    result = evaluate_submission(privileged, ranked, tmp_path)
    assert (result.submission.privileged, result.eligible) == ("pose", False)
    assert msgspec.json.decode((tmp_path / "timing.json").read_bytes(), type=Timing).isolation == "in-process"
    with pytest.raises(InputError) as caught:
        evaluate_submission(load_submission("thesis", {}), ranked, tmp_path)
    assert "the runs of another submission" in str(caught.value)


def test_the_oracle_is_the_reference_with_the_true_pose(
    setting_out: Suite, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ranked = msgspec.structs.replace(setting_out, ranked=True, time_limit_s=0.5)
    (tmp_path / "mine.toml").write_bytes(to_toml(msgspec.structs.replace(ranked, ranked=False)))
    with pytest.raises(SystemExit) as done:
        main(["evaluate", "submission", "oracle", "--suite", str(tmp_path / "mine.toml"), "--out", str(tmp_path / "a")])
    assert done.value.code == 0
    assert "the submission is not in a sandbox (true pose)" in capsys.readouterr().err
    result = evaluate_submission(load_submission("oracle", {}), ranked, tmp_path / "b")
    assert (result.submission.name, result.submission.privileged, result.eligible) == ("oracle", "pose", False)
    assert title(result.submission) == "oracle with true pose"
    reference = evaluate_submission(load_submission("reference", {}, "pose"), ranked, tmp_path / "c")
    assert reference.episodes == result.episodes
    with pytest.raises(UsageError, match="the oracle, which has the true pose"):
        load_submission("oracle", {}, "detections")


def test_no_truth_is_lent_to_a_folder(submission_of: MakeSubmission) -> None:
    folder = submission_of("Still").load.folder
    assert folder
    with pytest.raises(UsageError) as caught:
        load_submission(folder, {}, "detections")
    assert "--privileged detections" in str(caught.value)
    assert "the truth is lent to no other" in str(caught.value)


def test_a_driver_without_the_layer_is_refused(setting_out: Suite, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        evaluate_submission(load_submission("stand-still", {}, "pose"), setting_out, tmp_path)
    assert "neither looks nor locates itself" in str(caught.value)
