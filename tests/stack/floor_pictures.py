"""An oracle's pictures: the course's paint laid on a flat floor and looked at by tracing every pixel's ray."""

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.world.course import Course
from adc_bench.world.sensors import CameraMount, SensorRig

PER_M = 200
X0_M, Y0_M, X1_M, Y1_M = -9.5, -5.0, 9.5, 4.5


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


def road_mount() -> CameraMount:
    return SensorRig().camera("road")


def look(
    pose_world_robot: Pose2,
    *,
    pitch_error_rad: float = 0.0,
    roll_error_rad: float = 0.0,
    floor_level: float = 40.0,
    paint_level: float = 200.0,
    shade: float = 0.0,
    noise: float = 2.0,
    seed: int = 0,
) -> NDArray[np.uint8]:
    """Return the road camera's picture (240, 320, 3); `shade` darkens the left half of the floor by that share."""
    mount = road_mount()
    fine = mount.resized(2 * mount.width_px, 2 * mount.height_px)
    camera, pose = fine.camera(), pose_world_robot.to_pose3() @ fine.pose_robot_camera(pitch_error_rad, roll_error_rad)
    u, v = np.meshgrid(np.arange(fine.width_px) + 0.5, np.arange(fine.height_px) + 0.5)
    rays = camera.rays(np.stack([u.ravel(), v.ravel()], axis=1)) @ pose.rotation.T
    with np.errstate(divide="ignore"):
        reach = np.where(rays[:, 2] < -1e-6, -pose.translation_m[2] / rays[:, 2], np.nan)
    x = (pose.translation_m[0] + reach * rays[:, 0]).reshape(u.shape)
    y = (pose.translation_m[1] + reach * rays[:, 1]).reshape(u.shape)
    columns, rows = (x - X0_M) * PER_M - 0.5, (Y1_M - y) * PER_M - 0.5
    paint = cv2.remap(
        painted_floor(),
        np.nan_to_num(columns, nan=-9).astype(np.float32),
        np.nan_to_num(rows, nan=-9).astype(np.float32),
        cv2.INTER_LINEAR,
    )
    level = floor_level + (paint_level - floor_level) * paint.astype(np.float64) / 255
    local = pose_world_robot.inverse().transform(np.stack([x.ravel(), y.ravel()], axis=1))[:, 1].reshape(u.shape)
    level = np.where(local > 0.1, level * (1 - shade), level)
    small = cv2.resize(level, (mount.width_px, mount.height_px), interpolation=cv2.INTER_AREA)
    small = small + noise * np.random.default_rng(seed).standard_normal(small.shape)
    return np.repeat(np.clip(np.round(small), 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)
