"""The smallest whole submission: drives in a circle without looking, and believes it never moved."""

from adc_bench.api import Command, Mission, Observation


class CircleDriver:
    """Turns left at half a metre a second."""

    def start(self, mission: Mission) -> None:
        """Note where the run begins."""
        self._start_pose = mission.start_pose

    def step(self, observation: Observation) -> Command:
        """Answer every observation with the same command."""
        return Command(v_mps=0.5, omega_radps=0.2, pose_world_robot=self._start_pose)
