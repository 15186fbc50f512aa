"""An oracle's pictures: the course's paint laid on a flat floor and looked at by tracing every pixel's ray."""

from collections.abc import Sequence
from functools import cache, lru_cache

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.world.course import Course
from adc_bench.world.sensors import CameraMount, Lens, SensorRig

PER_M = 200
X0_M, Y0_M, X1_M, Y1_M = -9.5, -5.0, 9.5, 4.5

# None, the benchmark's, and the published one of the competition's robots.
LENSES = {
    "pinhole": Lens(k1=0.0, k2=0.0),
    "barrel": Lens(k1=-0.12, k2=0.015),
    "strong barrel": Lens(k1=-0.276, k2=0.045),
}


@cache
def painted_floor() -> NDArray[np.uint8]:
    """Return the top view, row 0 at y = Y1_M, 255 where there is paint."""
    floor = np.zeros((round((Y1_M - Y0_M) * PER_M), round((X1_M - X0_M) * PER_M)), dtype=np.uint8)
    for polygon in Course().paint:
        ring = np.asarray(polygon.exterior.coords)
        rings = [ring, *(np.asarray(hole.coords) for hole in polygon.interiors)]
        cells = [np.stack([(r[:, 0] - X0_M), (Y1_M - r[:, 1])], axis=1) * PER_M - 0.5 for r in rings]
        mark = np.zeros_like(floor)
        cv2.fillPoly(mark, [np.round(c * 16).astype(np.int32) for c in cells], 255, shift=4)
        floor = np.maximum(floor, mark)
    return floor


def road_mount(lens: Lens | None = None) -> CameraMount:
    """Return the rig's road camera behind a lens, its own if none is named."""
    mount = SensorRig().camera("road")
    return mount if lens is None else msgspec.structs.replace(mount, lens=lens)


def look(
    pose_world_robot: Pose2,
    *,
    mount: CameraMount | None = None,
    pitch_error_rad: float = 0.0,
    roll_error_rad: float = 0.0,
    floor_level: float = 40.0,
    paint_level: float = 200.0,
    shade: float = 0.0,
    far_light: float = 1.0,
    far_m: float = 1.4,
    vignetting: float = 0.0,
    during: Sequence[Pose2] = (Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0),),
    noise: float = 2.0,
    seed: int = 0,
) -> NDArray[np.uint8]:
    """Return the road camera's picture (240, 320, 3).

    `shade` darkens the left half of the floor by that share; `far_light` is how much more light falls beyond `far_m`
    ahead; `vignetting` is the share of light lost in the corners; the picture is the mean over the robot's poses
    `during` the exposure, seen from the first.
    """
    mount = mount or road_mount()
    x, y = _floor_of_pixels(mount, pitch_error_rad, roll_error_rad)
    paint = np.mean([_paint(pose_world_robot @ moved, x, y) for moved in during], axis=0)
    level = floor_level + (paint_level - floor_level) * paint
    level = np.where(y > 0.1, level * (1 - shade), level) * np.where(x > far_m, far_light, 1.0)
    small = cv2.resize(level, (mount.width_px, mount.height_px), interpolation=cv2.INTER_AREA)
    v, u = np.indices(small.shape) + 0.5
    corner_px = np.hypot(mount.width_px / 2, mount.height_px / 2)
    small = small * (1 - vignetting * ((u - mount.width_px / 2) ** 2 + (v - mount.height_px / 2) ** 2) / corner_px**2)
    small = small + noise * np.random.default_rng(seed).standard_normal(small.shape)
    return np.repeat(np.clip(np.round(small), 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)


@lru_cache(maxsize=2)
def _floor_of_pixels(
    mount: CameraMount, pitch_error_rad: float, roll_error_rad: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the floor's x and y (robot frame) under the pixels' quarters, (480, 640) each; nan above the horizon."""
    pose = mount.pose_robot_camera(pitch_error_rad, roll_error_rad)
    rays = _rays(mount) @ pose.rotation.T
    reach = -pose.translation_m[2] / np.where(rays[..., 2] < -1e-6, rays[..., 2], np.nan)
    return pose.translation_m[0] + reach * rays[..., 0], pose.translation_m[1] + reach * rays[..., 1]


@cache
def _rays(mount: CameraMount) -> NDArray[np.float64]:
    """Return the directions (480, 640, 3) through the pixels' quarters, in the camera's frame."""
    camera = mount.camera()
    u, v = np.meshgrid(np.arange(2 * mount.width_px) / 2 + 0.25, np.arange(2 * mount.height_px) / 2 + 0.25)
    pixels = np.stack([u.ravel(), v.ravel()], axis=1)
    lens = np.array([camera.k1, camera.k2, 0.0, 0.0])
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 60, 1e-10)
    plane = cv2.undistortPoints(pixels[:, None], camera.matrix(), lens, criteria=criteria)[:, 0]
    return np.column_stack([plane, np.ones(len(plane))]).reshape(*u.shape, 3)


def _paint(pose_world_robot: Pose2, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the share of paint at floor points given by x and y in the robot frame."""
    x_world, y_world = pose_world_robot.transform(np.stack([x.ravel(), y.ravel()], axis=1)).T
    columns, rows = (x_world - X0_M) * PER_M - 0.5, (Y1_M - y_world) * PER_M - 0.5
    columns, rows = (np.nan_to_num(part.reshape(x.shape), nan=-9).astype(np.float32) for part in (columns, rows))
    return np.asarray(cv2.remap(painted_floor(), columns, rows, cv2.INTER_LINEAR), dtype=np.float64) / 255
