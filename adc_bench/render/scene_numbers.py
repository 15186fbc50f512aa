"""The numbers that our shader reads beside materials: they travel as three point lights that shine on nothing.

light 0: the robot's x, y and half length; cosine and sine of its yaw, half width.
light 1: the first floodlight in the robot's frame, and its weight; half length, half width and height of the hall.
light 2: the second floodlight; 1 / the open floor's light.
"""

import math
from typing import Final

import numpy as np
import sapien

from adc_bench.geometry import Pose3
from adc_bench.render.arena_parts import hall_bounds
from adc_bench.render.light import Lighting

FAR_M: Final = 1e4
STEEPEST = 1e-4  # way per height of the light of a floodlight that stands upright


class SceneNumbers:
    """Three carriers in a SAPIEN scene; the robot is far away until it is placed."""

    def __init__(self, scene: sapien.Scene, lighting: Lighting) -> None:
        self._scene, self._lighting = scene, lighting
        self._lights: list[sapien.render.RenderPointLightComponent] = []
        scenario = lighting.scenario
        robot, (_, _, half_length, half_width) = scenario.robot, hall_bounds(scenario)
        self._half_length_m, self._half_width_m = robot.length_m / 2, robot.width_m / 2
        total = scenario.look.flood_share or 1.0
        self._floods = [(f.azimuth_rad, 1 / math.tan(f.elevation_rad), f.share / total) for f in scenario.look.floods]
        for colour in (
            (0.0, 0.0, 0.0),
            (half_length, half_width, scenario.arena_spec.hall_height_m),
            (1 / lighting.level, 0.0, 0.0),
        ):
            self._add(colour)
        self.place_robot(Pose3(rotation=np.eye(3), translation_m=np.array([FAR_M, FAR_M, 0.0])))

    def _add(self, colour: tuple[float, float, float]) -> None:
        light = sapien.render.RenderPointLightComponent()
        light.set_color(list(colour))
        entity = sapien.Entity()
        entity.add_component(light)
        self._scene.add_entity(entity)
        self._lights.append(light)

    def place_robot(self, pose: Pose3) -> None:
        """Tell the shader where the robot is."""
        x, y, _ = pose.translation_m
        yaw = math.atan2(pose.rotation[1, 0], pose.rotation[0, 0])
        self._carry(0, (x, y, self._half_length_m))
        self._lights[0].set_color([math.cos(yaw), math.sin(yaw), self._half_width_m])
        for k, (azimuth, way, weight) in enumerate(self._floods, start=1):
            along, across = way * math.cos(azimuth - yaw), way * math.sin(azimuth - yaw)
            self._carry(k, (_inverse(along), _inverse(across), weight))

    def _carry(self, k: int, numbers: tuple[float, float, float]) -> None:
        self._lights[k].entity.set_pose(sapien.Pose([float(n) for n in numbers]))

    def remove(self) -> None:
        """Take the carriers out of the scene."""
        for light in self._lights:
            self._scene.remove_entity(light.entity)
        self._lights.clear()


def _inverse(way: float) -> float:
    return 1 / math.copysign(max(abs(way), STEEPEST), way)
