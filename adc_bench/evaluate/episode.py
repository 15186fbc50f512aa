"""One run: the loop that owns time, with the simulator and the submission's process side by side."""

import math
from collections import deque
from dataclasses import dataclass
from functools import lru_cache

import msgspec

from adc_bench.api import Command, Mission, SeenObject
from adc_bench.evaluate.agent_side import AgentSide, Load
from adc_bench.evaluate.course_progress import Moment
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.log import Drive, Header, Hit, Row
from adc_bench.evaluate.recorded_log import Encoders
from adc_bench.evaluate.referee import Referee
from adc_bench.evaluate.referee_watch import Watch
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.sensed import Sensed
from adc_bench.evaluate.trace import Driven, Trace, to_its_end, wait_loaded
from adc_bench.evaluate.witness import Truth, Witness
from adc_bench.geometry import Pose3
from adc_bench.render import ArenaRenderer
from adc_bench.sim import Delivery, Simulation
from adc_bench.world.frame import Label
from adc_bench.world.robot import Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig


@dataclass(frozen=True, kw_only=True)
class Plan:
    """All that fixes one run."""

    header: Header
    scenario: Scenario
    mission: Mission
    load: Load
    rules: Rules


@dataclass(frozen=True, kw_only=True)
class Shot:
    """What a camera took at a time: the picture's file, and the objects in view if the rig's semantic camera is it.

    `labels` are for a witness alone; without one there are none.
    """

    time_s: float
    picture: bytes
    objects: tuple[SeenObject, ...]
    labels: tuple[Label, ...]


def drive(plan: Plan, renderer: ArenaRenderer, agent: AgentSide, witness: Witness | None = None) -> Driven[Row]:
    """Drive one run; whatever goes wrong in it ends it and nothing else, and its ending says what.

    A witness hears the truth of every observation before the agent is asked.

    Raises:
        AdcBenchError: this machine cannot render.
    """
    trace: Trace[Row] = Trace()
    trace.unanswered = (_before(plan),)
    return to_its_end(trace, lambda: _ending(plan, renderer, agent, trace, witness))


def _before(plan: Plan) -> Row:
    """Return the row of a run that has not begun."""
    return Row(
        step=0,
        time_s=0.0,
        truth=plan.header.start_pose,
        v_mps=0.0,
        omega_radps=0.0,
        panel="stop",
        encoders=Encoders(time_s=(), left_ticks=(), right_ticks=()),
        hits=(),
        answer=None,
    )


def _ending(
    plan: Plan, renderer: ArenaRenderer, agent: AgentSide, trace: Trace[Row], witness: Witness | None
) -> Ending:
    renderer.load(plan.scenario)
    run = _Run(plan, renderer, agent, trace, witness)
    wait_loaded(trace, agent)
    return run.to_its_end()


@lru_cache(maxsize=1)
def process_renderer(rig: SensorRig) -> ArenaRenderer:
    """Return this process' renderer: starting one is dear, so it is kept from run to run."""
    return ArenaRenderer(rig)


class _Run:
    """Observation k goes to the agent; while it thinks, the robot drives step k under an earlier command and
    observation k + 1 is rendered. So a command acts one control step after its observation, or more by the latency
    that the submission declares.
    """

    def __init__(
        self, plan: Plan, renderer: ArenaRenderer, agent: AgentSide, trace: Trace[Row], witness: Witness | None
    ) -> None:
        self._plan, self._renderer, self._agent, self._trace = plan, renderer, agent, trace
        self._witness = witness
        period_s = plan.rules.control_period_s
        self._simulation = Simulation(plan.scenario, plan.header.start_pose, period_s, dynamics=plan.rules.dynamics)
        self._referee = Referee(course=plan.scenario.course, rules=plan.rules, header=plan.header)
        late_steps = 1 + math.ceil(plan.mission.latency_s / period_s - 1e-9)
        self._commands = deque([(0.0, 0.0)] * late_steps)
        self._shots: dict[str, Delivery[Shot]] = {
            mount.name: Delivery(mount.latency_s) for mount in plan.scenario.rig.cameras
        }

    def to_its_end(self) -> Ending:
        trace = self._trace
        watch = self._referee.begin(self._simulation.state().pose_world_robot)
        row, sensed = self._observe(watch)
        trace.unanswered = (row,)
        self._agent.start(self._plan.mission)
        while (reason := self._referee.end(watch)) is None:
            trace.asked = sensed
            self._agent.ask(sensed)
            self._simulation.advance(*self._commands.popleft())
            if not self._is_sound():
                return Ending(reason=Reason.PHYSICS)
            watch = self._referee.step(watch, self._moment())
            before, (row, sensed) = row, self._observe(watch)
            trace.rows.append(msgspec.structs.replace(before, answer=self._answer()))
            trace.unanswered = (row,)
        return Ending(reason=reason)

    def _moment(self) -> Moment:
        return Moment(time_s=self._simulation.time_s, pose=self._simulation.state().pose_world_robot)

    def _observe(self, watch: Watch) -> tuple[Row, Sensed]:
        """Return the truth and the sensors now: the row without its answer, and the agent's observation."""
        simulation, panel = self._simulation, self._referee.panels(watch)
        step, time_s, state = simulation.step_index, simulation.time_s, simulation.state()
        self._renderer.set_panel(panel)
        readings = simulation.read_sensors()
        encoders = readings.encoders
        row = Row(
            step=step,
            time_s=time_s,
            truth=state.pose_world_robot,
            v_mps=state.v_mps,
            omega_radps=state.omega_radps,
            panel=panel,
            encoders=Encoders(
                time_s=tuple(encoders.time_s.tolist()),
                left_ticks=tuple(encoders.left_ticks.tolist()),
                right_ticks=tuple(encoders.right_ticks.tolist()),
            ),
            hits=tuple(
                Hit(time_s=hit.time_s, with_name=hit.with_name, impulse_ns=hit.impulse_ns)
                for hit in simulation.take_contacts()
            ),
            answer=None,
        )
        self._take_pictures(step, time_s, Motion(v_mps=state.v_mps, omega_radps=state.omega_radps))
        taken = self._arrived(time_s)
        sensed = Sensed(
            step=step,
            time_s=time_s,
            pictures={name: (shot.time_s, shot.picture) for name, shot in taken.items()},
            encoders=encoders,
            imu=readings.imu,
            laser=readings.laser,
            objects=tuple(seen for shot in taken.values() for seen in shot.objects),
        )
        if self._witness:
            labels = {name: shot.labels for name, shot in taken.items()}
            self._witness.hear(Truth(step=step, pose=state.pose_world_robot, labels=labels))
        return row, sensed

    def _take_pictures(self, step: int, time_s: float, motion: Motion) -> None:
        """Let the cameras fire whose turn it is; their pictures arrive when their latency has passed."""
        rig, pose = self._plan.scenario.rig, self._simulation.pose3_world_robot()
        due = [mount.name for mount in rig.cameras if step % mount.period_steps == 0]
        if due:
            self._renderer.place(self._simulation.body_poses(), self._simulation.torn_tapes())
        for name in due:
            picture, labels = self._picture(name, pose, time_s, motion)
            names_objects = rig.semantic is not None and rig.semantic.camera == name
            objects = self._renderer.objects_in_view(name, pose) if names_objects else ()
            self._shots[name].put(time_s, Shot(time_s=time_s, picture=picture, objects=objects, labels=labels))

    def _picture(self, name: str, pose: Pose3, time_s: float, motion: Motion) -> tuple[bytes, tuple[Label, ...]]:
        """Return a camera's picture; for a witness with its labels."""
        if self._witness is None:
            return self._renderer.picture(name, pose, time_s=time_s, motion=motion), ()
        index = self._simulation.step_index
        frame = self._renderer.drive_frame(index, name, pose, time_s=time_s, motion=motion)
        return frame.jpeg, frame.labels

    def _arrived(self, time_s: float) -> dict[str, Shot]:
        """Return the newest shot of each camera from which one arrived since the last step."""
        arrived = {name: delivery.take(time_s) for name, delivery in self._shots.items()}
        return {name: shots[-1] for name, shots in arrived.items() if shots}

    def _answer(self) -> Drive:
        """Take the agent's answer to the observation before, queue its command, and return it for the log."""
        answer = self._agent.answer()
        self._trace.compute_s.append(answer.compute_s)
        command = answer.answer
        assert isinstance(command, Command)
        estimate = command.pose_world_robot
        self._commands.append((command.v_mps, command.omega_radps))
        return Drive(
            v_mps=command.v_mps,
            omega_radps=command.omega_radps,
            estimate=estimate,
            covariance=command.covariance,
            sign=command.sign,
        )

    def _is_sound(self) -> bool:
        state = self._simulation.state()
        figures = (*msgspec.structs.astuple(state.pose_world_robot), state.v_mps, state.omega_radps)
        return all(math.isfinite(figure) for figure in figures)
