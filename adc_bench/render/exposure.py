"""Auto-exposure: what the light on the floor ahead asks for, how the camera follows it, how it is brought about.

An exposure of 1 shows radiance 1 of our unit (a white surface under 300 lux) at full scale.
"""

import math
from collections.abc import Callable, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose2, Pose3
from adc_bench.render.light import UNIT_LUX
from adc_bench.world.look import Look
from adc_bench.world.robot import Motion
from adc_bench.world.sensors import Imaging

DARKEST_LUX = 60.0  # below this the gain is at its end and the picture stays dark
WHITE_PAINT = 0.7  # of full scale, where paint that gives back 0.8 of the light comes out
# Exposure time that gives exposure 1 at the lowest gain: N^2 C / (E S) of the incident-light meter's equation with
# f/2, C = 250, E = 300 lux and ISO 280, a small camera's.
UNIT_SHUTTER_S = 0.012
USUAL_SHUTTER_S = 1 / 60  # what a camera without blur draws its noise by
# Floor points, in the robot frame, whose light the exposure follows.
METERED_ROBOT = np.array([[x, y, 0.0] for x in (0.6, 1.1, 1.6) for y in (-0.4, 0.0, 0.4)])
WAY_BACK_STEP_S, WAY_BACK_LAGS = 0.1, 3.0

Irradiance = Callable[[NDArray[np.float64]], NDArray[np.float64]]


class Metered(msgspec.Struct, frozen=True, kw_only=True):
    """A camera's auto-exposure at one moment."""

    time_s: float
    exposure: float


def exposure_for(look: Look, irradiance: float) -> float:
    """Return the exposure a camera settles on when the floor before it gets this irradiance (unit 300 lux)."""
    return WHITE_PAINT / 0.8 / max(irradiance, DARKEST_LUX / UNIT_LUX) * math.pow(2.0, look.exposure_bias_ev)


def settled(look: Look, floor_irradiance: Irradiance, poses_world_robot: Sequence[Pose3]) -> list[float]:
    """Return the exposures that the light on the floor before the robot leads to, pose by pose."""
    points = np.concatenate([pose.transform(METERED_ROBOT)[:, :2] for pose in poses_world_robot])
    irradiance = floor_irradiance(points).reshape(len(poses_world_robot), -1).mean(axis=1)
    return [exposure_for(look, light) for light in irradiance.tolist()]


def seen_floor(camera: Camera, pose_world_camera: Pose3) -> NDArray[np.float64]:
    """Return floor points (n, 2) spread over what a camera sees of the floor, or the one under it if it sees none."""
    u, v = np.meshgrid(np.linspace(0, camera.width_px, 9), np.linspace(0, camera.height_px, 9))
    rays = camera.rays(np.column_stack([u.ravel(), v.ravel()])) @ pose_world_camera.rotation.T
    rays = rays[rays[:, 2] < -1e-3]
    x_m, y_m, z_m = pose_world_camera.translation_m
    return (x_m, y_m) - rays[:, :2] / rays[:, 2:] * z_m if len(rays) else np.array([[x_m, y_m]])


def follow(before: Metered | None, wanted: float, time_s: float, lag_s: float) -> Metered:
    """Return the exposure at `time_s`: the distance to what is wanted, in stops, falls by e each `lag_s`.

    A camera without a past has settled.
    """
    if before is None:
        return Metered(time_s=time_s, exposure=wanted)
    left = math.exp(-(time_s - before.time_s) / lag_s) if lag_s > 0 else 0.0
    return Metered(time_s=time_s, exposure=wanted * (before.exposure / wanted) ** left)


def way_back(pose_world_robot: Pose3, motion: Motion, lag_s: float) -> Sequence[tuple[float, Pose3]]:
    """Return (time, pose) of a robot that came here at a steady motion, oldest first, now at time 0."""
    steps = math.ceil(WAY_BACK_LAGS * lag_s / WAY_BACK_STEP_S) if motion.v_mps or motion.omega_radps else 0
    times = [-k * WAY_BACK_STEP_S for k in range(steps, -1, -1)]
    return [(time_s, pose_world_robot @ moved(motion, time_s).to_pose3()) for time_s in times]


def moved(motion: Motion, time_s: float) -> Pose2:
    """Return where a robot at a steady motion is after `time_s`, seen from where it was: an arc of a circle."""
    turned = motion.omega_radps * time_s
    half = turned / 2
    chord = motion.v_mps * time_s * (math.sin(half) / half if half else 1.0)
    return Pose2(x_m=chord * math.cos(half), y_m=chord * math.sin(half), yaw_rad=turned)


def shutter_and_gain(exposure: float, imaging: Imaging) -> tuple[float, float]:
    """Return the exposure time and the gain that bring an exposure about: first a longer time, then more gain.

    A camera whose longest time is 0 takes its picture in an instant, with the gain of a usual one.
    """
    longest_s = imaging.shutter_max_s or USUAL_SHUTTER_S
    shutter_s = min(exposure * UNIT_SHUTTER_S, longest_s)
    gain = exposure * UNIT_SHUTTER_S / shutter_s
    return min(shutter_s, imaging.shutter_max_s), gain
