"""The scenario that is measured, and where its camera goes: once round the lap, along the robot's lane."""

from collections.abc import Iterator
from itertools import cycle

import msgspec
import numpy as np

from adc_bench.geometry import Path, Pose3
from adc_bench.world.arena import ArenaSpec, Tunnel
from adc_bench.world.categories import PANEL_SIGNS
from adc_bench.world.course import Course
from adc_bench.world.layout import BoxPlace, Layout, Place, Works
from adc_bench.world.look import FLOOR_TEXTURES, LIGHT_SETS, WALL_TEXTURES, LookFamily, draw_look
from adc_bench.world.robot import RobotParams
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import CameraMount, Lens, SensorRig
from adc_bench.world.setup import set_up
from adc_bench.world.streams import stream

STOPS = 24  # poses round the lap
ALL_LOOKS = LookFamily(floors=FLOOR_TEXTURES, walls=WALL_TEXTURES, light_sets=tuple(LIGHT_SETS))
PARKED = (-1.855, -3.783)  # a box in the parking bay


def rig(width_px: int, height_px: int, *, cameras: int = 1, lens: Lens | None = None) -> SensorRig:
    """Return the first cameras of the default rig at this picture size; with another lens if one is given."""

    def resized(mount: CameraMount) -> CameraMount:
        mount = mount.resized(width_px, height_px)
        return msgspec.structs.replace(mount, lens=lens, period_steps=1) if lens else mount

    return SensorRig(cameras=tuple(resized(mount) for mount in SensorRig().cameras[:cameras]))


def arena(number: int, sensor_rig: SensorRig) -> Scenario:
    """Return a scenario with everything in it that an arena can hold; its look is drawn from all looks.

    The lane stays free: tunnel over it, boxes beside it, road-works to both sides of it.
    """
    rng, course = stream(number, "benchmark"), Course()
    lap, beside_m = course.lap, course.spec.radius_outer_m - course.spec.radius_centre_m  # to the other lane
    boxes = [*(_beside(lap, s_m + rng.uniform(-0.5, 0.5), beside_m) for s_m in (28.0, 31.0, 34.0)), PARKED]
    layout = Layout(
        name="everything",
        tunnel=Tunnel(start_s_m=float(rng.uniform(9.9, 10.3)), length_m=float(rng.uniform(2.0, 2.4))),
        boxes=tuple(BoxPlace(x_m=x_m, y_m=y_m) for x_m, y_m in boxes),
        works=Works(
            left=tuple(_beside(lap, 1.9 + 0.8 * k, 0.6) for k in range(5)),
            right=tuple(_beside(lap, 2.3 + 0.8 * k, -0.6) for k in range(4)),
        ),
        signs=True,
    )
    return set_up(
        name=f"everything-{number}",
        seed=number,
        look=draw_look(ALL_LOOKS, rng),
        panel_sign=PANEL_SIGNS[number % len(PANEL_SIGNS)],
        layout=layout,
        course=course.spec,
        arena=ArenaSpec(),
        robot=RobotParams(),
        rig=sensor_rig,
    )


def _beside(lap: Path, s_m: float, left_m: float) -> Place:
    (x_m, y_m), *_ = lap.pose(s_m).transform([(0.0, left_m)])
    return float(x_m), float(y_m)


def stops(scenario: Scenario) -> Iterator[Pose3]:
    """Yield the robot's poses round the lap, again and again."""
    lap = scenario.course.lap
    return cycle([lap.pose(s_m).to_pose3() for s_m in np.arange(STOPS) * lap.length_m / STOPS])
