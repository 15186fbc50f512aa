"""A suite done into a result folder: what is there already is kept, what is missing is done, then all is scored."""

import itertools
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec

from adc_bench.dataset.drives import DriveDataset
from adc_bench.dataset.layout import write_file
from adc_bench.engine import Done, Engine, default_workers, run_tasks
from adc_bench.errors import InputError, UsageError
from adc_bench.evaluate.driving import RunFiles, RunTask, agent_side, run_task, software
from adc_bench.evaluate.folder import ResultFolder
from adc_bench.evaluate.log import AnyLog, read_header
from adc_bench.evaluate.plans import AnyPlan, any_plan_for, plans_at_hand, renderer_name, suite_of
from adc_bench.evaluate.plot import plot_paths
from adc_bench.evaluate.results import Result, result_of, timing_of, to_json
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.submission import Submission, require_kind
from adc_bench.evaluate.suite import AnySuite, Suite, check_salt, rules_for, rules_id
from adc_bench.evaluate.witness import Witness


def evaluate_submission(
    submission: Submission,
    suite: AnySuite,
    out: Path,
    *,
    episodes: int | None = None,
    overwrite: bool = False,
    engine: Engine = "local",
    workers: int | None = 1,
    in_process: bool = False,
    record: bool = False,
    salt: bytes | None = None,
    tell: Callable[[int], None] = lambda done: None,
    rules: Rules = RULES,
) -> Result:
    """Do a suite's first `episodes` runs (all if None) and write the result folder; `tell` hears how many are done.
    A hidden suite needs its salt. To `record` makes a film of each drive; one without a film is driven again for it.

    The bytes are the same for any engine, any number of workers (see `run_tasks`), and `in_process` or not.

    Raises:
        UsageError: `in_process` with a submission that is a command, or to record what is not driven.
        InputError: the submission is not of the suite's kind or cannot be loaded, the folder belongs to another run or
            is damaged, or the salt is not the suite's.
        MachineError: this machine, or a node, cannot render; workers died again and again; no cluster.
    """
    require_kind(submission, suite.kind)
    check_salt(suite, salt)
    if record and not isinstance(suite, Suite):
        raise _not_driven(suite)
    run = RunId(
        suite=suite,
        rules=rules_id(suite, rules),
        submission=submission.id,
        software=software(renderer_name(suite, rules_for(suite, rules), salt)),
    )
    folder = ResultFolder(out)
    folder.open(run, overwrite=overwrite)
    plans = [any_plan_for(run, seed, submission, rules, salt) for seed in suite.seeds[:episodes]]
    _do(folder, plans, submission, engine=engine, workers=workers, in_process=in_process, record=record, tell=tell)
    return _score_into(folder, suite, len(plans), rules)


def _do(
    folder: ResultFolder,
    plans: Sequence[AnyPlan],
    submission: Submission,
    *,
    engine: Engine,
    workers: int | None,
    in_process: bool,
    record: bool = False,
    tell: Callable[[int], None],
) -> None:
    """Do the runs that are missing in the folder, or their films."""
    rules = plans[0].rules
    missing = [plan for plan in plans if not (folder.has(plan.header) and _is_filmed(folder, plan, record))]
    if missing:
        privileged = submission.id.privileged
        witness = Witness(privileged) if privileged else None
        with agent_side(submission.load, rules, in_process=in_process, witness=witness) as agent:
            agent.wait_loaded()
    if engine == "local":
        workers = min(workers or default_workers(), max(len(missing), 1))
    kept = len(plans) - len(missing)
    tell(kept)
    counted = itertools.count(kept + 1)

    def told(done: Done[RunFiles]) -> None:
        _put(folder, done.result, submission.id.latency_s, rules)
        tell(next(counted))

    tasks = (RunTask(plan=plan, in_process=in_process, filmed=record) for plan in missing)
    run_tasks(run_task, tasks, engine=engine, workers=workers, done=told)


def _is_filmed(folder: ResultFolder, plan: AnyPlan, wanted: bool) -> bool:
    return not wanted or folder.film_path(plan.header.scenario).is_file()


def _not_driven(suite: AnySuite) -> UsageError:
    return UsageError(
        where="--record",
        found=f"suite {suite.name}, in which nothing is driven",
        wanted="a suite for drivers",
        todo="leave --record out",
    )


def evaluate_localization(
    submission: Submission,
    data: DriveDataset,
    *,
    workers: int = 1,
    in_process: bool = False,
    tell: Callable[[int], None] = lambda done: None,
    rules: Rules = RULES,
) -> Result:
    """Return what a localiser makes of every drive of a dataset; nothing of it may stand on a leaderboard.

    Raises:
        UsageError: `in_process` with a submission that is a command.
        InputError: the submission is no localiser or cannot be loaded, or the dataset is damaged.
    """
    require_kind(submission, "localizer")
    suite, manifest = suite_of(data), data.frames.manifest
    rules = msgspec.structs.replace(rules, rig=msgspec.structs.replace(rules.rig, cameras=manifest.cameras))
    run = RunId(
        suite=suite,
        rules=rules_id(suite, rules),
        submission=submission.id,
        software=software(manifest.software["renderer"]),
    )
    plans = list(plans_at_hand(run, data, submission, rules))
    with tempfile.TemporaryDirectory(prefix="adc-bench-") as out:
        folder = ResultFolder(Path(out))
        folder.open(run, overwrite=False)
        _do(folder, plans, submission, engine="local", workers=workers, in_process=in_process, tell=tell)
        return result_of(_logs(folder, suite, len(plans)), len(plans), rules)


def _put(folder: ResultFolder, run: RunFiles, latency_s: float, rules: Rules) -> None:
    """Write what a run left, its log last: a log that is there always has the rest."""
    write_file(folder.printed_path(run.scenario), run.printed)
    if run.film:
        write_file(folder.film_path(run.scenario), run.film)
    folder.put_failure(run.scenario, run.failure)
    timings = folder.timings() | {run.scenario: run.timing}
    write_file(folder.timing_path, to_json(timing_of(timings, latency_s, rules.control_period_s)))
    write_file(folder.episode_path(run.scenario), run.log)


def _score_into(folder: ResultFolder, suite: AnySuite, planned: int, rules: Rules) -> Result:
    logs = _logs(folder, suite, planned)
    result = result_of(logs, planned, rules)
    write_file(folder.result_path, to_json(result))
    plot_paths(logs, folder.paths_path, rules)
    return result


def rescore(out: Path, rules: Rules = RULES) -> Result:
    """Score a result folder again from its logs, and write result.json and paths.png anew.

    Raises:
        InputError: there are no logs, one is damaged, or they were driven under other rules.
    """
    folder = ResultFolder(out)
    suite = _driven_suite(folder, rules)
    return _score_into(folder, suite, folder.planned() or len(suite.seeds), rules)


def result_in(out: Path, rules: Rules = RULES) -> Result:
    """Return what `rescore` would write as result.json, and write nothing.

    Raises:
        InputError: as `rescore`.
    """
    folder = ResultFolder(out)
    suite = _driven_suite(folder, rules)
    planned = folder.planned() or len(suite.seeds)
    return result_of(_logs(folder, suite, planned), planned, rules)


def _logs(folder: ResultFolder, suite: AnySuite, planned: int) -> list[AnyLog]:
    logs = folder.logs([suite.scenario_name(seed) for seed in suite.seeds[:planned]])
    if not logs:
        raise _no_log(folder)
    return logs


def _no_log(folder: ResultFolder) -> InputError:
    return InputError(
        where=str(folder.root),
        found="no episode log",
        wanted="a result folder with episodes/*.jsonl",
        todo="name the --out folder of an `adc-bench evaluate submission`",
    )


def _driven_suite(folder: ResultFolder, rules: Rules) -> AnySuite:
    headers = [read_header(path) for path in folder.episode_paths()]
    header = next(iter(headers), None)
    if header is None:
        raise _no_log(folder)
    suite = header.run.suite
    if header.run.rules != rules_id(suite, rules):
        raise InputError(
            where=str(folder.episode_path(header.scenario)),
            found=f"rules {header.run.rules.id} {header.run.rules.sha256[:12]}",
            wanted=f"rules {rules.id} {rules_id(suite, rules).sha256[:12]}, those of this version",
            todo="rescore with the version that drove it, or drive again",
        )
    return suite
