"""The laser range finder: a fan of beams in the plane of its mount, which pitches and rolls with the robot."""

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import LaserScan
from adc_bench.geometry import Pose3
from adc_bench.sim.delivery import Delivery
from adc_bench.sim.rays import Obstacles
from adc_bench.world.sensors import LaserSpec
from adc_bench.world.streams import stream

Array = NDArray[np.float64]


def beam_angles_rad(spec: LaserSpec) -> Array:
    """Return the angle of each beam (beams,), left positive."""
    angles: Array = np.arange(spec.beams, dtype=np.float64) * spec.step_rad - spec.field_rad / 2
    return angles


class Laser:
    """Sees everything but the robot itself. What is nearer than the range's beginning reads as that beginning."""

    def __init__(self, seed: int, spec: LaserSpec) -> None:
        self._spec, self._noise = spec, stream(seed, "sim", "laser_noise")
        angles = beam_angles_rad(spec)
        self._beams_robot = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
        self._scans: Delivery[LaserScan] = Delivery(spec.latency_s)

    def sample(self, time_s: float, pose_world_robot: Pose3, obstacles: Obstacles) -> None:
        """Take a scan, all of it at one moment."""
        true_m = self.true_ranges_m(pose_world_robot, obstacles)
        self._scans.put(time_s, LaserScan(time_s=time_s, ranges_m=self._noisy(true_m)))

    def true_ranges_m(self, pose_world_robot: Pose3, obstacles: Obstacles) -> Array:
        """Return the distance (beams,) to the first thing on each beam, inf for nothing in range."""
        spec, rotation = self._spec, pose_world_robot.rotation
        origin_m = rotation @ np.array([spec.x_m, 0.0, spec.z_m]) + pose_world_robot.translation_m
        beams = self._beams_robot @ rotation.T
        return obstacles.fan_distances_m(origin_m, beams, rotation[:, 2], spec.range_max_m)

    def _noisy(self, true_m: Array) -> Array:
        """Return what is read; each beam takes one draw, whether or not it meets something."""
        spec = self._spec
        sd_m = np.maximum(spec.noise_near_m, spec.noise_share * np.minimum(true_m, spec.range_max_m))
        read_m = true_m + sd_m * self._noise.standard_normal(true_m.size)
        clipped: Array = np.clip(read_m, spec.range_min_m, spec.range_max_m)
        return clipped

    def read(self, now_s: float) -> LaserScan | None:
        """Return the newest scan that has arrived since the last call."""
        arrived = self._scans.take(now_s)
        return arrived[-1] if arrived else None
