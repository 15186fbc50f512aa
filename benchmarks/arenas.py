"""The scenario that is measured, and where its camera goes: once round the lap, along the robot's lane."""

from collections.abc import Iterator
from itertools import cycle

import msgspec
import numpy as np

from adc_bench.dataset import load_split
from adc_bench.dataset.sampling import draw_scenario
from adc_bench.geometry import Pose2, Pose3, rotation_zyx
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import CameraMount, Lens, SensorRig

STOPS = 24  # poses round the lap


def rig(width_px: int, height_px: int, *, cameras: int = 1, lens: Lens | None = None) -> SensorRig:
    """Return the first cameras of the default rig at this picture size; with another lens if one is given."""

    def resized(mount: CameraMount) -> CameraMount:
        mount = mount.resized(width_px, height_px)
        return msgspec.structs.replace(mount, lens=lens, period_steps=1) if lens else mount

    return SensorRig(cameras=tuple(resized(mount) for mount in SensorRig().cameras[:cameras]))


def arena(number: int, sensor_rig: SensorRig) -> Scenario:
    """Return a scenario."""
    return draw_scenario(load_split("train"), number, sensor_rig)


def stops(scenario: Scenario) -> Iterator[Pose3]:
    """Yield the robot's poses round the lap, again and again."""
    lap = scenario.course.lap
    return cycle([on_floor(lap.pose(s_m)) for s_m in np.arange(STOPS) * lap.length_m / STOPS])


def on_floor(pose: Pose2) -> Pose3:
    """Return the pose in space of an upright robot."""
    return Pose3(rotation=rotation_zyx(pose.yaw_rad, 0.0, 0.0), translation_m=np.array([pose.x_m, pose.y_m, 0.0]))
