"""A suite driven into a result folder: what is there already is kept, what is missing is driven, then all is scored."""

from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

from adc_bench import __version__
from adc_bench.dataset.layout import write_file
from adc_bench.errors import InputError
from adc_bench.evaluate.episode import Plan, drive
from adc_bench.evaluate.folder import ResultFolder, first_line
from adc_bench.evaluate.log import EpisodeLog, Header, RunId, write_log
from adc_bench.evaluate.plot import plot_paths
from adc_bench.evaluate.results import Result, episode_timing, result_of, timing_of, to_json
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.submission import Submission
from adc_bench.evaluate.suite import Suite, mission_for, rules_for, rules_id, scenario_for, start_step
from adc_bench.render import ArenaRenderer

PACKAGES = ("sapien", "numpy", "scipy", "opencv-python-headless", "torch")


def evaluate_submission(
    submission: Submission,
    suite: Suite,
    out: Path,
    *,
    episodes: int | None = None,
    overwrite: bool = False,
    tell: Callable[[int], None] = lambda done: None,
    rules: Rules = RULES,
) -> Result:
    """Drive a suite's first `episodes` runs (all if None) and write the result folder; `tell` hears how many are done.

    Raises:
        InputError: the submission cannot be loaded, or the folder belongs to another run.
        MachineError: this machine cannot render.
    """
    rules = rules_for(suite, rules)
    renderer = ArenaRenderer(rules.rig)
    run = RunId(
        suite=suite,
        rules=rules_id(suite, rules),
        submission=submission.id,
        software=software(renderer.device_name),
    )
    folder = ResultFolder(out)
    folder.open(run, overwrite=overwrite)
    plans = [plan_for(run, seed, submission, rules) for seed in suite.seeds[:episodes]]
    for done, plan in enumerate(plans, start=1):
        if not folder.has(plan.header):
            _drive_into(folder, plan, renderer)
        tell(done)
    return _score_into(folder, suite, len(plans), rules)


def software(renderer_name: str) -> dict[str, str]:
    """Return the versions that a run's bytes depend on."""
    return {"adc_bench": __version__, "renderer": renderer_name, **{name: version(name) for name in PACKAGES}}


def plan_for(run: RunId, seed: int, submission: Submission, rules: Rules = RULES) -> Plan:
    """Return all that fixes a seed's run."""
    rules = rules_for(run.suite, rules)
    scenario = scenario_for(run.suite, seed, rules)
    options = submission.load.options
    mission = mission_for(run.suite, latency_s=submission.id.latency_s, options=options, rules=rules)
    header = Header(
        run=run,
        scenario=scenario.name,
        seed=seed,
        look=scenario.look,
        start_pose=mission.start_pose,
        start_step=start_step(run.suite, seed, rules),
        wheel_separation_m=scenario.robot_truth.wheel_separation_m,
    )
    return Plan(header=header, scenario=scenario, mission=mission, load=submission.load, rules=rules)


def _drive_into(folder: ResultFolder, plan: Plan, renderer: ArenaRenderer) -> None:
    """Drive a run and write its timing, then its log: a log that is there always has its timing."""
    scenario = plan.header.scenario
    driven = drive(plan, renderer, folder.child_log_path(scenario))
    timing = episode_timing(driven.wall_s, driven.rows[-1].time_s, driven.compute_s)
    timings = folder.timings() | {scenario: timing}
    whole = timing_of(timings, plan.mission.latency_s, plan.rules.control_period_s)
    write_file(folder.timing_path, to_json(whole))
    write_log(folder.episode_path(scenario), plan.header, driven.rows, driven.ending)


def _score_into(folder: ResultFolder, suite: Suite, planned: int, rules: Rules) -> Result:
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


def _logs(folder: ResultFolder, suite: Suite, planned: int) -> list[EpisodeLog]:
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


def _driven_suite(folder: ResultFolder, rules: Rules) -> Suite:
    headers = [first_line(path) for path in folder.episode_paths()]
    header = next((header for header in headers if header is not None), None)
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
