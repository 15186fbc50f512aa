"""A localiser without a driver: it says where a robot is that others drive."""

from collections.abc import Callable
from typing import Generic

from adc_bench.api import Command, Mission, Observation
from adc_bench.stack.driver import Localizing, Place, covariance_figures


class LoneLocalizer(Generic[Place]):
    """An agent whose commands are to stand still, and of no effect; its pose and covariance are its localiser's."""

    def __init__(self, localizer: Callable[[Mission], Localizing[Place]]) -> None:
        self._make_localizer = localizer

    def start(self, mission: Mission) -> None:
        """Take the mission's map, robot, rig and start pose."""
        self._localizer = self._make_localizer(mission)
        self._place = self._localizer.start()

    def step(self, observation: Observation) -> Command:
        """Answer with the estimate at the observation's time."""
        self._place = self._localizer.step(self._place, observation)
        belief = self._place.belief
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=belief.pose, covariance=covariance_figures(belief))
