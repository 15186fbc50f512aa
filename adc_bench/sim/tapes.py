"""The tapes between cones. A tape has no mass and pulls at nothing: it hangs where its cones are until it tears.

It tears when the robot's outline crosses it, which counts as a contact without impulse, and when its cones have come
so far apart that it is stretched beyond its limit, which does not. (Nothing public says what the competition's tape
does; a thin barrier tape gives way to a robot of 9 kg at once.)
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2, Pose3
from adc_bench.sim.rays import between_walls
from adc_bench.world.robot import RobotParams
from adc_bench.world.works import TAPE_HEIGHT_M, Tape

Array = NDArray[np.float64]


class Tapes:
    """The tapes of a scenario, whole or torn."""

    def __init__(self, tapes: Sequence[Tape], robot: RobotParams, stretch_max: float) -> None:
        self._whole = {tape.name: tape for tape in tapes}
        self._half_outline_m = np.array([robot.length_m, robot.width_m]) / 2
        self._stretch_max = stretch_max
        self.torn: frozenset[str] = frozenset()

    def step(self, poses: Mapping[str, Pose3], pose_world_robot: Pose2) -> list[str]:
        """Tear what does not hold with bodies and robot where they are now; return those that the robot ran through."""
        if not self._whole:
            return []
        ends_m = np.array([[_end_m(poses[tape.first]), _end_m(poses[tape.second])] for tape in self._whole.values()])
        rest_m = np.array([tape.rest_length_m for tape in self._whole.values()])
        stretched = np.linalg.norm(ends_m[:, 1] - ends_m[:, 0], axis=1) > rest_m * (1 + self._stretch_max)
        crossed = self._crossed(ends_m[:, :, :2], pose_world_robot)
        names = list(self._whole)
        for name in [name for name, gone in zip(names, stretched | crossed, strict=True) if gone]:
            del self._whole[name]
            self.torn |= {name}
        return [name for name, hit in zip(names, crossed, strict=True) if hit]

    def _crossed(self, ends_m: Array, pose_world_robot: Pose2) -> NDArray[np.bool_]:
        """Return which segments (m, 2, 2) touch the robot's outline from above; every robot is as tall as a tape."""
        robot_m = pose_world_robot.inverse().transform(ends_m.reshape(-1, 2)).reshape(-1, 2, 2) / self._half_outline_m
        start, along = robot_m[:, 0], robot_m[:, 1] - robot_m[:, 0]
        enter, leave = between_walls(start[:, :, None], along[:, :, None])
        hit: NDArray[np.bool_] = np.maximum(enter[:, 0], 0.0) <= np.minimum(leave[:, 0], 1.0)
        return hit


def _end_m(pose: Pose3) -> Array:
    """Return where a tape is tied to a cone: on its axis."""
    end: Array = pose.rotation[:, 2] * TAPE_HEIGHT_M + pose.translation_m
    return end
