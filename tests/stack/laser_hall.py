"""A hall of made things for a laser: what a scan at a pose returns, and whether the robot's outline meets a thing."""

import math

import numpy as np
import shapely

from adc_bench.api import LaserScan
from adc_bench.geometry import Pose2
from adc_bench.sim.rays import Obstacles
from adc_bench.world.footprints import extents
from adc_bench.world.robot import Motion, RobotParams
from adc_bench.world.sensors import LaserSpec
from adc_bench.world.solids import Shape, Solid

LASER = LaserSpec()
ROBOT = RobotParams()


def thing(x_m: float, y_m: float, length_m: float, width_m: float, yaw_rad: float = 0.0, shape: Shape = "box") -> Solid:
    """Return a thing half a metre high on the floor."""
    return Solid(
        name="thing",
        kind="cabinet",
        centre_m=(x_m, y_m, 0.25),
        size_m=(length_m, width_m, 0.5),
        yaw_rad=yaw_rad,
        shape=shape,
    )


class Hall:
    """Things, a laser with noise, and a robot that follows its commands at once."""

    def __init__(self, things: list[Solid], seed: int = 0) -> None:
        self._rays, self._noise = Obstacles(things, ()), np.random.default_rng(seed)
        parts = extents(things)
        self.floor = shapely.union_all([parts.footprint(k) for k in range(len(things))])

    def scan(self, pose: Pose2, time_s: float = 0.0) -> LaserScan:
        """Return what the laser of a robot at a pose reads."""
        angles = pose.yaw_rad + np.arange(LASER.beams) * LASER.step_rad - LASER.field_rad / 2
        beams = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
        (origin,) = pose.transform([(LASER.x_m, 0.0)])
        true_m = self._rays.fan_distances_m(
            np.array([*origin, LASER.z_m]), beams, np.array([0.0, 0.0, 1.0]), LASER.range_max_m
        )
        true_m = np.minimum(true_m, LASER.range_max_m)
        read_m = true_m * (1 + LASER.noise_share * self._noise.standard_normal(LASER.beams))
        return LaserScan(time_s=time_s, ranges_m=np.clip(read_m, LASER.range_min_m, LASER.range_max_m))

    def clearance_m(self, pose: Pose2) -> float:
        """Return the distance from the robot's outline to the nearest thing."""
        half_length, half_width = ROBOT.length_m / 2, ROBOT.width_m / 2
        corners = [(half_length, half_width), (-half_length, half_width), (-half_length, -half_width)]
        outline = shapely.Polygon(pose.transform([*corners, (half_length, -half_width)]))
        return float(shapely.distance(outline, self.floor))


def moved(pose: Pose2, motion: Motion, period_s: float) -> Pose2:
    """Return the pose after a step of motion, by its middle heading."""
    half = motion.omega_radps * period_s / 2
    x_m, y_m = motion.v_mps * period_s * math.cos(half), motion.v_mps * period_s * math.sin(half)
    return pose @ Pose2(x_m=x_m, y_m=y_m, yaw_rad=2 * half)
