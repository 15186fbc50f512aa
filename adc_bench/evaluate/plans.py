"""From a suite's seed to all that fixes its run."""

from collections.abc import Iterator

import msgspec

from adc_bench.dataset.drive_script import DriveScript
from adc_bench.dataset.drives import DriveDataset
from adc_bench.dataset.layout import Manifest
from adc_bench.evaluate.episode import Plan, process_renderer
from adc_bench.evaluate.log import Header
from adc_bench.evaluate.recorded_log import DetectionHeader, LocalizationHeader
from adc_bench.evaluate.recorded_suite import DetectionSuite, LocalizationSuite
from adc_bench.evaluate.recording import AtHand, Source
from adc_bench.evaluate.replay import ReplayPlan, mission_over
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.submission import Submission
from adc_bench.evaluate.suite import AnySuite, Suite, mission_for, rules_for, scenario_for, start_step
from adc_bench.generate.plan import ShardTask, plan_dataset
from adc_bench.geometry import Pose2
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig

AnyPlan = Plan | ReplayPlan
NOWHERE = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)  # pictures have no start


def any_plan_for(
    run: RunId, seed: int, submission: Submission, rules: Rules = RULES, salt: bytes | None = None
) -> AnyPlan:
    """Return all that fixes a seed's run; a hidden suite needs its salt.

    Raises:
        InputError: the run's arena cannot be.
        MachineError: this machine cannot render.
    """
    suite = run.suite
    if isinstance(suite, Suite):
        return plan_for(run, seed, submission, rules, salt)
    number = suite.seeds.index(seed)
    source = ShardTask(out="", number=number, plan=recording_plan(suite, salt), salt=salt)
    if isinstance(suite, DetectionSuite):
        header = DetectionHeader(run=run, scenario=suite.scenario_name(seed), seed=seed)
        lasts_s = suite.pictures * rules.control_period_s
        return _replay_plan(header, source, NOWHERE, lasts_s, submission, rules)
    scenario, plan = suite.drawn(seed, SensorRig(cameras=source.plan.cameras), salt)
    return _localization_plan(run, seed, scenario, plan.script, source, submission, rules)


def plan_for(run: RunId, seed: int, submission: Submission, rules: Rules = RULES, salt: bytes | None = None) -> Plan:
    """Return all that fixes a seed's drive; a hidden suite needs its salt."""
    suite, rules = run.suite, rules_for(run.suite, rules)
    assert isinstance(suite, Suite)
    scenario = scenario_for(suite, seed, rules, salt)
    options = submission.load.options
    mission = mission_for(suite, latency_s=submission.id.latency_s, options=options, rules=rules)
    header = Header(
        run=run,
        scenario=scenario.name,
        seed=seed,
        look=scenario.look,
        start_pose=mission.start_pose,
        start_step=start_step(suite, seed, rules, salt),
        orders=suite.trial(seed).orders,
        layout=scenario.layout,
        signs=scenario.signs,
        wheel_separation_m=scenario.robot_truth.wheel_separation_m,
    )
    return Plan(header=header, scenario=scenario, mission=mission, load=submission.load, rules=rules)


def plans_at_hand(run: RunId, data: DriveDataset, submission: Submission, rules: Rules) -> Iterator[ReplayPlan]:
    """Yield all that fixes a run over each drive of a dataset, whose suite is that of `suite_of`."""
    store = data.frames.store
    for number, (seed, entry) in enumerate(zip(run.suite.seeds, data.frames.manifest.shards, strict=True)):
        source = AtHand(root=store.root, file=entry.file, frames=entry.frames)
        script = data.drive(number).script
        yield _localization_plan(run, seed, data.scenario(number), script, source, submission, rules)


def suite_of(data: DriveDataset) -> LocalizationSuite:
    """Return a dataset's drives as a suite."""
    manifest = data.frames.manifest
    drives = msgspec.structs.replace(manifest.split.drives, count=len(data))
    split = msgspec.structs.replace(manifest.split, drives=drives)
    return LocalizationSuite(name=split.name, split=split, ranked=False, salt_sha256=manifest.salt_sha256)


def recording_plan(suite: LocalizationSuite | DetectionSuite, salt: bytes | None) -> Manifest:
    """Return what is recorded for a suite, and by which software.

    Raises:
        MachineError: this machine cannot render.
    """
    if isinstance(suite, DetectionSuite):
        return plan_dataset(suite.split, None, kind="frames", frames_per_shard=suite.pictures, salt=salt)
    return plan_dataset(suite.split, None, kind="drives", salt=salt)


def renderer_name(suite: AnySuite, rules: Rules, salt: bytes | None) -> str:
    """Return the name of what renders a suite's pictures on this machine.

    Raises:
        MachineError: it cannot render.
    """
    if isinstance(suite, Suite):
        return process_renderer(rules.rig).device_name
    return recording_plan(suite, salt).software["renderer"]


def _localization_plan(
    run: RunId,
    seed: int,
    scenario: Scenario,
    script: DriveScript,
    source: Source,
    submission: Submission,
    rules: Rules,
) -> ReplayPlan:
    header = LocalizationHeader(
        run=run,
        scenario=run.suite.scenario_name(seed),
        seed=seed,
        look=scenario.look,
        start_pose=script.start_pose,
        mission=script.mission,
        behaviour=script.behaviour,
    )
    return _replay_plan(header, source, script.start_pose, script.duration_s, submission, rules)


def _replay_plan(
    header: LocalizationHeader | DetectionHeader,
    source: Source,
    start_pose: Pose2,
    lasts_s: float,
    submission: Submission,
    rules: Rules,
) -> ReplayPlan:
    suite = header.run.suite
    mission = mission_over(
        suite.name,
        start_pose,
        lasts_s,
        latency_s=submission.id.latency_s,
        options=submission.load.options,
        rules=rules_for(suite, rules),
    )
    return ReplayPlan(
        header=header, source=source, mission=mission, load=submission.load, rules=rules_for(suite, rules)
    )
