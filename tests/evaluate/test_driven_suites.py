"""Proofs on whole suites: every hostile submission on one, and suites that are cut off or driven elsewhere."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import hostile
import msgspec
import pytest
from made_hostile import hostile_submission
from test_agent_process import command_lines
from test_equal_results import scored

from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.run import evaluate_submission
from adc_bench.evaluate.sandbox import sandbox_fault
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import Suite, load_suite

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "circle_driver"
LIMITS = Limits(
    load_s=60.0,
    start_s=10.0,
    step_s=5.0,
    total_s=30.0,
    memory_bytes=384 * 2**20,
    processes=10,
    tmp_bytes=4 * 2**20,
)
# Those whose answers are commands in good order: printing, killing nobody but others, and looking around are no faults.
HARMLESS = ("PrintsMuch", "ReadsOtherProcesses", "IsAlwaysSlow")
FACTORIES = sorted(
    name
    for name, kind in vars(hostile).items()
    if isinstance(kind, type) and issubclass(kind, hostile.Hostile) and kind is not hostile.Hostile
)


def tiny(seeds: tuple[int, ...]) -> Suite:
    return msgspec.structs.replace(load_suite("dev"), start_delay_s=(0.1, 0.1), time_limit_s=0.4, seeds=seeds)


@pytest.mark.slow
@pytest.mark.skipif(bool(sandbox_fault()), reason="no sandbox")
@pytest.mark.parametrize("factory", FACTORIES)
def test_a_suite_completes_whatever_a_submission_does(factory: str, tmp_path: Path) -> None:
    submission = hostile_submission(tmp_path / "submission", factory, tmp_path / "target.txt")
    rules = msgspec.structs.replace(RULES, limits=LIMITS)
    result = evaluate_submission(submission, tiny((1, 2)), tmp_path / "out", rules=rules)
    assert (result.status, result.completed) == ("success", 2)
    statuses = {episode.status for episode in result.episodes}
    assert len(statuses) == 1, "both runs end alike"
    assert statuses <= ({"timeout"} if factory in HARMLESS else {"agent-failed", "invalid"})
    assert len({episode.reason for episode in result.episodes}) == 1
    assert not (tmp_path / "target.txt").exists()
    assert str(tmp_path) not in command_lines()


def evaluating(submission: Path, suite: Path, out: Path, *words: str) -> list[str]:
    code = "from adc_bench.cli.main import main; main()"
    command = (sys.executable, "-c", code, "evaluate", "submission", str(submission))
    return [*command, "--suite", str(suite), "--out", str(out), *words]


@pytest.fixture
def suite_file(tmp_path: Path) -> Path:
    text = (ROOT / "splits" / "suites" / "dev.toml").read_text()
    path = tmp_path / "four.toml"
    path.write_text(text.replace("seeds = [6001]", "seeds = [1, 2, 3, 4]").replace("= 60.0", "= 1.0", 1))
    return path


@pytest.mark.slow
def test_a_suite_killed_again_and_again_goes_on_to_the_same_bytes(suite_file: Path, tmp_path: Path) -> None:
    out, whole, driver = (tmp_path / name for name in ("out", "whole", "driver"))
    shutil.copytree(EXAMPLE, driver)
    subprocess.run(evaluating(driver, suite_file, whole), check=True)
    chance = random.Random(time.time_ns())
    for _ in range(3):
        process = subprocess.Popen(evaluating(driver, suite_file, out, "--workers", "2"), start_new_session=True)
        time.sleep(chance.uniform(5.0, 20.0))
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    for _ in range(100):
        if str(driver) not in command_lines():
            break
        time.sleep(0.1)
    assert str(driver) not in command_lines(), "a submission outlived the loop"
    subprocess.run(evaluating(driver, suite_file, out, "--workers", "2"), check=True)
    assert scored(out) == scored(whole)


@pytest.mark.slow
def test_a_ray_cluster_gives_the_same_bytes(suite_file: Path, tmp_path: Path, ray_cluster: Any) -> None:
    suite, submission = load_suite(str(suite_file)), load_submission(str(EXAMPLE), {})
    evaluate_submission(submission, suite, tmp_path / "here", episodes=3)
    evaluate_submission(submission, suite, tmp_path / "ray", episodes=3, engine="ray", workers=2)
    assert scored(tmp_path / "ray") == scored(tmp_path / "here")
