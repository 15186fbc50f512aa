"""The agent that never moves: the floor of every table."""

from adc_bench.api import Command, Mission, Observation


class StandStill:
    """Says that it is where it started, and is right."""

    def start(self, mission: Mission) -> None:
        """Take the start pose."""
        self._pose = mission.start_pose

    def step(self, observation: Observation) -> Command:
        """Answer with no motion."""
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=self._pose)
