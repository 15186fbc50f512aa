"""The smallest whole localizer: believes its wheels."""

import math

from adc_bench.api import Command, Mission, Observation
from adc_bench.geometry import Pose2


class WheelLocalizer:
    """Adds up what the encoders say, from the start pose on."""

    def start(self, mission: Mission) -> None:
        """Note where the robot starts, and its nominal figures."""
        self._pose, self._robot, self._ticks = mission.start_pose, mission.robot, None

    def step(self, observation: Observation) -> Command:
        """Answer with the pose at the last encoder sample; the commands do nothing."""
        for left, right in zip(observation.encoders.left_ticks, observation.encoders.right_ticks, strict=True):
            left_before, right_before = self._ticks or (left, right)
            left_m, right_m = self._way_m(left - left_before), self._way_m(right - right_before)
            turn_rad = (right_m - left_m) / self._robot.wheel_separation_m
            self._pose = self._pose @ Pose2(x_m=(left_m + right_m) / 2, y_m=0.0, yaw_rad=turn_rad)
            self._ticks = left, right
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=self._pose)

    def _way_m(self, ticks: int) -> float:
        return ticks * 2 * math.pi * self._robot.wheel_radius_m / self._robot.encoder_ticks_per_turn
