"""Everything that can be found wrong with a submission before it is scored, under the limits that scoring has."""

from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

import msgspec

from adc_bench.errors import InputError
from adc_bench.evaluate.driving import process_renderer, software
from adc_bench.evaluate.ending import Status
from adc_bench.evaluate.episode import Driven, Plan, drive
from adc_bench.evaluate.isolation import AgentProcess
from adc_bench.evaluate.log import RunId
from adc_bench.evaluate.results import episode_timing, timing_of
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.run import plan_for
from adc_bench.evaluate.sandbox import sandbox_fault
from adc_bench.evaluate.submission import Submission, load_submission, require_driver
from adc_bench.evaluate.submission_files import files_of
from adc_bench.evaluate.suite import load_suite, rules_for, rules_id

SUITE = "dev"
DRIVE_S = 3.0  # from the first order
FAULTS: tuple[Status, ...] = ("agent-failed", "invalid")


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

    It is loaded, and drives the first seconds of the suite `dev` twice.

    Raises:
        MachineError: this machine cannot render.
    """
    try:
        submission = load_submission(source, {})
        require_driver(submission)
        yield _files(submission)
        yield _sandbox()
        plan = _plan(submission, rules)
        loaded = _loaded(plan)
    except InputError as error:
        yield Check(name="loads", found=error.found, ok=False, wanted=error.wanted, todo=error.todo)
        return
    yield loaded
    first, printed = _driven(plan)
    yield _drives(first)
    if first.ending.status not in FAULTS:
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


def _plan(submission: Submission, rules: Rules) -> Plan:
    suite = msgspec.structs.replace(load_suite(SUITE), time_limit_s=DRIVE_S)
    device = process_renderer(rules_for(suite, rules).rig).device_name
    run = RunId(suite=suite, rules=rules_id(suite, rules), submission=submission.id, software=software(device))
    return plan_for(run, suite.seeds[0], submission, rules)


def _loaded(plan: Plan) -> Check:
    begun = perf_counter()
    with AgentProcess(plan.load, plan.rules.rig, plan.rules.limits) as agent:
        agent.wait_loaded()
        return Check(name="loads", found=f"in {perf_counter() - begun:.1f} s of {plan.rules.limits.load_s:g} s")


def _driven(plan: Plan) -> tuple[Driven, bytes]:
    process = AgentProcess(plan.load, plan.rules.rig, plan.rules.limits)
    with process as agent:
        driven = drive(plan, process_renderer(plan.scenario.rig), agent)
    return driven, process.printed


def _drives(driven: Driven) -> Check:
    steps, ending = len(driven.rows) - 1, driven.ending
    if ending.status not in FAULTS:
        return Check(name="drives", found=f"{steps} steps, then {ending.reason}")
    found = f"{ending.status} ({ending.reason}) at step {steps}: {ending.detail}"
    return Check(name="drives", found=found, ok=False, wanted="a command for every observation", todo="mend the code")


def _repeats(first: Driven, second: Driven) -> Check:
    pairs = zip(first.rows, second.rows, strict=False)
    differing = next((one.step for one, two in pairs if one != two), None)
    if differing is None and first.ending == second.ending:
        return Check(name="repeats", found="the same commands for the same observations")
    found = f"other commands in a second run, from step {max((differing or 1) - 1, 0)} on"
    if differing is None:
        found = f"{second.ending.reason} in a second run, {first.ending.reason} in the first"
    todo = "seed its random numbers, and let no clock decide"
    wanted = "the same commands for the same observations: a result is to be repeatable"
    return Check(name="repeats", found=found, ok=False, counts=False, wanted=wanted, todo=todo)


def _latency(driven: Driven, plan: Plan) -> Check:
    timing = episode_timing(driven.wall_s, driven.rows[-1].time_s, driven.compute_s, "bubblewrap")
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
