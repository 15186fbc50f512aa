"""Everything that can be found wrong with a submission before it is scored, under the limits that scoring has."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

import msgspec

from adc_bench.api import Kind
from adc_bench.errors import InputError
from adc_bench.evaluate.driving import driven_by, software
from adc_bench.evaluate.ending import FAILED
from adc_bench.evaluate.isolation import AgentProcess
from adc_bench.evaluate.plans import AnyPlan, any_plan_for, renderer_name
from adc_bench.evaluate.recorded_suite import LocalizationSuite
from adc_bench.evaluate.results import episode_timing, timing_of
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.sandbox import sandbox_fault
from adc_bench.evaluate.submission import Submission, load_submission
from adc_bench.evaluate.submission_files import files_of
from adc_bench.evaluate.suite import AnySuite, Suite, load_suite, rules_for, rules_id
from adc_bench.evaluate.trace import Driven

SUITES: Mapping[Kind, str] = {"driver": "dev", "localizer": "dev-loc", "detector": "dev-det"}
DRIVE_S = 3.0  # from the first order, or from a recording's begin


class Check(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One thing looked at. Where it is not in order, `wanted` and `todo` say what would be; `counts` says whether it
    keeps the submission from being scored, or is good to know.
    """

    name: str
    found: str
    ok: bool = True
    counts: bool = True
    wanted: str = ""
    todo: str = ""


def validate(source: str, rules: Rules = RULES) -> Iterator[Check]:
    """Yield the checks of a submission (a folder, or a built-in one's name); one that fails may be the last.

    It is loaded, and does the beginning of the short suite for its kind twice.

    Raises:
        MachineError: this machine cannot render.
    """
    try:
        submission = load_submission(source, {})
        yield _files(submission)
        yield _sandbox()
        plan = _plan(submission, rules)
        loaded = _loaded(plan)
    except InputError as error:
        yield Check(name="loads", found=error.found, ok=False, wanted=error.wanted, todo=error.todo)
        return
    yield loaded
    first, printed = _driven(plan)
    yield _answers(first, submission.id.kind)
    if first.ending.status not in FAILED:
        yield _repeats(first, _driven(plan)[0])
    yield _latency(first, plan)
    yield _output(printed, plan.rules.limits.printed_bytes)


def _files(submission: Submission) -> Check:
    folder = submission.load.folder
    found = "built in" if folder is None else f"{sum(1 for _ in files_of(Path(folder)))} files"
    return Check(name="files", found=f"{found}, sha256 {submission.id.sha256[:12]}")


def _sandbox() -> Check:
    fault = sandbox_fault()
    if not fault:
        return Check(name="sandbox", found="bubblewrap")
    wanted, todo = "a sandbox: no leaderboard takes a result without", "adc-bench doctor"
    return Check(name="sandbox", found=fault, ok=False, counts=False, wanted=wanted, todo=todo)


def _plan(submission: Submission, rules: Rules) -> AnyPlan:
    suite = _begun(load_suite(SUITES[submission.id.kind]))
    device = renderer_name(suite, rules_for(suite, rules), None)
    run = RunId(suite=suite, rules=rules_id(suite, rules), submission=submission.id, software=software(device))
    return any_plan_for(run, suite.seeds[0], submission, rules)


def _begun(suite: AnySuite) -> AnySuite:
    """Return a suite whose drives end after a few seconds; a set of pictures is short as it is."""
    if isinstance(suite, Suite):
        return msgspec.structs.replace(suite, time_limit_s=DRIVE_S)
    if isinstance(suite, LocalizationSuite):
        drives = msgspec.structs.replace(suite.split.drives, duration_s=(DRIVE_S, DRIVE_S))
        return msgspec.structs.replace(suite, split=msgspec.structs.replace(suite.split, drives=drives))
    return suite


def _loaded(plan: AnyPlan) -> Check:
    begun = perf_counter()
    with AgentProcess(plan.load, plan.rules.rig, plan.rules.limits) as agent:
        agent.wait_loaded()
        return Check(name="loads", found=f"in {perf_counter() - begun:.1f} s of {plan.rules.limits.load_s:g} s")


def _driven(plan: AnyPlan) -> tuple[Driven[Any], bytes]:
    process = AgentProcess(plan.load, plan.rules.rig, plan.rules.limits)
    with process as agent:
        driven = driven_by(plan, agent)
    return driven, process.printed


def _answers(driven: Driven[Any], kind: Kind) -> Check:
    name, steps, ending = "drives" if kind == "driver" else "answers", len(driven.compute_s), driven.ending
    if ending.status not in FAILED:
        return Check(name=name, found=f"{steps} steps, then {ending.reason}")
    found = f"{ending.status} ({ending.reason}) at step {steps}: {ending.detail}"
    return Check(name=name, found=found, ok=False, wanted="an answer to every observation", todo="mend the code")


def _repeats(first: Driven[Any], second: Driven[Any]) -> Check:
    pairs = zip(first.rows, second.rows, strict=False)
    differing = next((one.step for one, two in pairs if one != two), None)
    if differing is None and first.ending == second.ending:
        return Check(name="repeats", found="the same answers to the same observations")
    found = f"other answers in a second run, from step {max((differing or 1) - 1, 0)} on"
    if differing is None:
        found = f"{second.ending.reason} in a second run, {first.ending.reason} in the first"
    todo = "seed its random numbers, and let no clock decide"
    wanted = "the same answers to the same observations: a result is to be repeatable"
    return Check(name="repeats", found=found, ok=False, counts=False, wanted=wanted, todo=todo)


def _latency(driven: Driven[Any], plan: AnyPlan) -> Check:
    timing = episode_timing(driven.wall_s, driven.sim_time_s, driven.compute_s, "bubblewrap")
    latency = timing_of({"": timing}, plan.mission.latency_s, plan.rules.control_period_s).latency
    if latency.measured_p95_s is None:
        return Check(name="latency", found="no step was answered")
    found = f"{latency.measured_p95_s * 1e3:.1f} ms a step (95th percentile)"
    if latency.verdict == "within":
        return Check(name="latency", found=f"{found}, of {latency.allowed_s * 1e3:g} ms")
    needed_s = latency.measured_p95_s - plan.rules.control_period_s
    todo = f"declare latency_s = {needed_s:.2f} or more, or compute less"
    wanted = f"at most {latency.allowed_s * 1e3:g} ms: the control step and the declared latency"
    return Check(name="latency", found=found, ok=False, counts=False, wanted=wanted, todo=todo)


def _output(printed: bytes, kept_bytes: int) -> Check:
    if len(printed) <= kept_bytes:
        return Check(name="output", found=f"{len(printed)} bytes printed")
    wanted = f"at most {kept_bytes} bytes: the rest is not kept"
    found, todo = f"more than {kept_bytes} bytes printed in {DRIVE_S:g} s", "print less"
    return Check(name="output", found=found, ok=False, counts=False, wanted=wanted, todo=todo)
