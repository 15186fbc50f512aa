"""One run as a task for any worker: the plan goes in, the files of the run come out as bytes."""

import socket
from contextlib import AbstractContextManager
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import msgspec

from adc_bench import __version__
from adc_bench.errors import MachineError, UsageError
from adc_bench.evaluate.agent_side import AgentSide, Load
from adc_bench.evaluate.ending import FAILED, STATUS_OF
from adc_bench.evaluate.episode import Plan, drive, process_renderer
from adc_bench.evaluate.film import Camera, Film
from adc_bench.evaluate.in_process import InProcessAgent
from adc_bench.evaluate.isolation import AgentProcess
from adc_bench.evaluate.log import EpisodeLog, log_bytes
from adc_bench.evaluate.plans import AnyPlan
from adc_bench.evaluate.privileged import PrivilegedAgent
from adc_bench.evaluate.replay import replay
from adc_bench.evaluate.results import EpisodeTiming, episode_timing
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.sensed import Sensed
from adc_bench.evaluate.trace import Driven
from adc_bench.evaluate.witness import Witness
from adc_bench.generate.plan import ShardTask, plan_renderer

PACKAGES = ("sapien", "numpy", "scipy", "opencv-python-headless", "torch")


@dataclass(frozen=True, kw_only=True)
class RunTask:
    """A run to be done; `in_process` for a Python submission in the worker's own process; a drive may be filmed."""

    plan: AnyPlan
    in_process: bool
    filmed: bool = False


@dataclass(frozen=True, kw_only=True)
class RunFiles:
    """What a run leaves for the result folder; `failure` by file name, for a submission that failed; `film` is empty
    if it was not filmed.
    """

    scenario: str
    log: bytes
    printed: bytes
    timing: EpisodeTiming
    failure: dict[str, bytes]
    film: bytes = b""


def run_task(task: RunTask) -> RunFiles:
    """Do a run: a drive, or one over a recording.

    Raises:
        MachineError: this machine cannot render, or has other software than where the run was planned.
    """
    plan = task.plan
    _check_software(plan.header.run.software, software(_renderer_name(plan)))
    privileged = plan.header.run.submission.privileged
    witness = Witness(privileged) if privileged else None
    with agent_side(plan.load, plan.rules, in_process=task.in_process, witness=witness) as agent:
        camera = Camera(agent)
        driven = driven_by(plan, camera if task.filmed else agent, witness)
    return RunFiles(
        scenario=plan.header.scenario,
        log=log_bytes(plan.header, driven.rows, driven.ending),
        printed=agent.printed,
        timing=episode_timing(driven.wall_s, driven.sim_time_s, driven.compute_s, agent.isolation),
        failure=_failure(driven),
        film=_film(plan, driven, camera) if task.filmed else b"",
    )


def _film(plan: AnyPlan, driven: Driven[Any], camera: Camera) -> bytes:
    assert isinstance(plan, Plan), "recordings are not driven"
    log = EpisodeLog(header=plan.header, rows=driven.rows, ending=driven.ending)
    return Film(log=log, pictures=camera.pictures, scenario=plan.scenario, rules=plan.rules).mp4()


def _renderer_name(plan: AnyPlan) -> str:
    """Return what this machine renders the run's pictures with; those at hand are rendered already."""
    if isinstance(plan, Plan):
        return process_renderer(plan.scenario.rig).device_name
    if isinstance(plan.source, ShardTask):
        return plan_renderer(plan.source.plan).device_name
    return plan.header.run.software["renderer"]


def driven_by(plan: AnyPlan, agent: AgentSide, witness: Witness | None = None) -> Driven[Any]:
    """Return the run that a submission makes of a plan."""
    if isinstance(plan, Plan):
        return drive(plan, process_renderer(plan.scenario.rig), agent, witness)
    return replay(plan, agent)


def agent_side(
    load: Load, rules: Rules, *, in_process: bool, witness: Witness | None = None
) -> AbstractContextManager[InProcessAgent] | AbstractContextManager[AgentProcess]:
    """Return the submission for one run, to be entered; with a witness a built-in driver that is told some truth.

    Raises:
        UsageError: a command cannot run in process.
    """
    if witness:
        return InProcessAgent(load, rules.limits, lambda load, folder: PrivilegedAgent(load, witness))
    if not in_process:
        return AgentProcess(load, rules.rig, rules.limits)
    if load.command:
        raise UsageError(
            where="--in-process",
            found=f"a submission that is a command: {load.name}",
            wanted="one with an entry, module:factory",
            todo="leave --in-process out",
        )
    return InProcessAgent(load, rules.limits)


def software(renderer_name: str) -> dict[str, str]:
    """Return the versions that a run's bytes depend on."""
    return {"adc_bench": __version__, "renderer": renderer_name, **{name: version(name) for name in PACKAGES}}


def _check_software(wanted: dict[str, str], here: dict[str, str]) -> None:
    for name in sorted(wanted.keys() | here.keys()):
        if wanted.get(name) != here.get(name):
            raise MachineError(
                where=f"node {socket.gethostname()}",
                found=f"{name} {here.get(name)}",
                wanted=f"{name} {wanted.get(name)}, as where the run was started: others give other bytes",
                todo="install the same versions on every node, and keep to nodes whose processors are of one kind",
            )


def _failure(driven: Driven[Any]) -> dict[str, bytes]:
    """Return what the submission was given last, for one that failed: its pictures, and the rest as JSON."""
    last = driven.last_asked
    if STATUS_OF[driven.ending.reason] not in FAILED or last is None:
        return {}
    pictures = {f"{name}.jpg": jpeg for name, (_, jpeg) in last.pictures.items()}
    return {"observation.json": _as_json(last), **pictures}


def _as_json(sensed: Sensed) -> bytes:
    encoders, imu, laser = sensed.encoders, sensed.imu, sensed.laser
    told = {
        "step": sensed.step,
        "time_s": sensed.time_s,
        "pictures": {name: time_s for name, (time_s, _) in sensed.pictures.items()},
        "encoders": {name: values.tolist() for name, values in vars(encoders).items()},
        "imu": {name: values.tolist() for name, values in vars(imu).items()},
        "laser": None if laser is None else {"time_s": laser.time_s, "ranges_m": laser.ranges_m.tolist()},
        "objects": sensed.objects,
    }
    return msgspec.json.format(msgspec.json.encode(told), indent=2) + b"\n"
