"""The driver: steers by where its localiser has it, as its conduct says, which it shows the panels, and at the share of
its speed that caution leaves.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

from adc_bench.api import Command, Mission, Observation
from adc_bench.stack.caution import at_full_speed
from adc_bench.stack.conduct import Conduct
from adc_bench.stack.ekf import Belief
from adc_bench.stack.localizer import Detect
from adc_bench.stack.prediction import UnderWay, at_rest, send, when_acting
from adc_bench.world.robot import Motion


class Located(Protocol):
    """A localiser's state: it tells where the robot is believed to be."""

    @property
    def belief(self) -> Belief:
        """The pose at the last observation's time."""
        ...


Place = TypeVar("Place", bound=Located)
Progress = TypeVar("Progress")


class Localizing(Protocol[Place]):
    """Pure steps from observation to observation."""

    def start(self) -> Place:
        """Return the state at the mission's start pose."""
        ...

    def step(self, state: Place, observation: Observation) -> Place:
        """Return the state at the observation's time."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class DriverState(Generic[Place, Progress]):
    """Everything that one control step hands to the next."""

    place: Place
    progress: Progress
    under_way: UnderWay


class Driver(Generic[Place, Progress]):
    """An agent of the benchmark: a localiser and a conduct, made for the mission that it is told."""

    def __init__(
        self,
        detect: Detect,
        localizer: Callable[[Mission], Localizing[Place]],
        conduct: Callable[[Mission], Conduct[Progress]],
        caution: Callable[[Belief], float] = at_full_speed,
    ) -> None:
        self._detect, self._make_localizer, self._make_conduct = detect, localizer, conduct
        self._caution = caution

    def start(self, mission: Mission) -> None:
        """Take the mission's map, robot and rig."""
        self._mission = mission
        self._localizer, self._conduct = self._make_localizer(mission), self._make_conduct(mission)
        self._state = DriverState(
            place=self._localizer.start(),
            progress=self._conduct.start(),
            under_way=at_rest(mission.control_period_s, mission.latency_s),
        )

    def step(self, observation: Observation) -> Command:
        """Answer with the command, and the estimate at the observation's time."""
        state = replace(self._state, place=self._localizer.step(self._state.place, observation))
        state, command = self._steer(self._see(self._look(state, observation), observation))
        self._state = state
        belief = state.place.belief
        return Command(
            v_mps=command.v_mps,
            omega_radps=command.omega_radps,
            pose_world_robot=belief.pose,
            covariance=covariance_figures(belief),
            sign=self._conduct.report(state.progress),
        )

    def _look(self, state: DriverState[Place, Progress], observation: Observation) -> DriverState[Place, Progress]:
        """Return the state after a picture of the panel, detected in only where it matters."""
        picture = observation.pictures.get("panel")
        if picture is None or not self._conduct.looks(state.progress):
            return state
        progress = self._conduct.look(state.progress, state.place.belief.pose, self._detect(picture.rgb))
        return replace(state, progress=progress)

    def _see(self, state: DriverState[Place, Progress], observation: Observation) -> DriverState[Place, Progress]:
        """Return the state after a scan of the laser, if there is one."""
        if observation.laser is None:
            return state
        progress = self._conduct.see(state.progress, state.place.belief.pose, observation.laser)
        return replace(state, progress=progress)

    def _steer(self, state: DriverState[Place, Progress]) -> tuple[DriverState[Place, Progress], Motion]:
        """Return the state after sending the next command, and that."""
        robot, period_s = self._mission.robot, self._mission.control_period_s
        pose, motion = when_acting(state.under_way, robot, state.place.belief.pose, period_s)
        progress, wanted = self._conduct.steer(state.progress, pose, motion)
        share = self._caution(state.place.belief)
        command = Motion(v_mps=share * wanted.v_mps, omega_radps=share * wanted.omega_radps)
        return replace(state, progress=progress, under_way=send(state.under_way, robot, command, period_s)), command


def covariance_figures(belief: Belief) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Return the covariance's nine figures by rows."""
    a, b, c, d, e, f, g, h, i = (float(v) for v in belief.covariance.ravel())
    return a, b, c, d, e, f, g, h, i
