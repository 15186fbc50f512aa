"""The tapes between cones. A tape has no mass and pulls at nothing: it hangs where its cones are until it tears.

It tears when the robot's outline crosses it, which counts as a contact without impulse, and when its cones have come
so far apart that it is stretched beyond its limit, which does not. (Nothing public says what the competition's tape
does; a thin barrier tape gives way to a robot of 9 kg at once.)
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.sim.rays import between_walls
from adc_bench.world.robot import RobotParams
from adc_bench.world.works import TAPE_HEIGHT_M, Tape


class Tapes:
    """The tapes of a scenario, whole or torn."""

    def __init__(self, tapes: Sequence[Tape], robot: RobotParams, stretch_max: float) -> None:
        self._half_outline_m = np.array([robot.length_m, robot.width_m]) / 2
        self._names = [tape.name for tape in tapes]
        self._cones = [name for tape in tapes for name in (tape.first, tape.second)]
        self._longest_m = np.array([tape.rest_length_m for tape in tapes]) * (1 + stretch_max)
        self._whole = np.ones(len(tapes), dtype=bool)
        self._poses: list[Pose3] = []
        self.torn: frozenset[str] = frozenset()

    def step(self, poses: Mapping[str, Pose3], pose_world_robot: Pose3) -> list[str]:
        """Tear what does not hold with bodies and robot where they are now; return those that the robot ran through."""
        if not self._whole.any():
            return []
        self._follow(poses)
        crossed = self._whole & self._crossed(pose_world_robot)
        stretched = np.linalg.norm(self._ends_m[:, 1] - self._ends_m[:, 0], axis=1) > self._longest_m
        self._whole &= ~(crossed | stretched)
        if crossed.any() or stretched.any():
            self.torn = frozenset(name for name, whole in zip(self._names, self._whole, strict=True) if not whole)
        return [name for name, hit in zip(self._names, crossed, strict=True) if hit]

    def _follow(self, poses: Mapping[str, Pose3]) -> None:
        """Find the tapes' ends (m, 2, 3) anew if a cone has moved; a tape is tied to a cone on its axis."""
        now = [poses[name] for name in self._cones]
        if len(self._poses) != len(now) or any(a is not b for a, b in zip(now, self._poses, strict=True)):
            ends_m = [pose.rotation[:, 2] * TAPE_HEIGHT_M + pose.translation_m for pose in now]
            self._ends_m, self._poses = np.array(ends_m).reshape(-1, 2, 3), now

    def _crossed(self, pose_world_robot: Pose3) -> NDArray[np.bool_]:
        """Return which tapes (m,) touch the robot's outline seen from above; every robot is as tall as a tape."""
        robot_m = pose_world_robot.inverse().transform(self._ends_m.reshape(-1, 3))[:, :2].reshape(-1, 2, 2)
        start, end = np.moveaxis(robot_m / self._half_outline_m, 1, 0)
        enter, leave = between_walls(start[:, :, None], (end - start)[:, :, None])
        hit: NDArray[np.bool_] = np.maximum(enter[:, 0], 0.0) <= np.minimum(leave[:, 0], 1.0)
        return hit
