"""Motion blur: how far each part of the picture moves while the shutter is open.

An approximation in three respects. What the camera sees is the floor, and beyond FAR_M, or above the horizon, a wall at
that distance; so panels and boxes blur as the floor or wall behind them would. Only the robot moves. Over one exposure
the picture moves evenly and along straight lines, by what its midpoint says. Labels are those of mid-exposure.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render.exposure import moved
from adc_bench.world.robot import Motion

FAR_M = 6.0
CELL_PX = 16  # the flow is computed once in so many pixels each way
SHARP_PX = 0.7  # rows that move less are left as they are
BANDS = 6  # of rows, each blurred as finely as what moves furthest in it asks for
Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Flow:
    """How a picture moves over one exposure.

    `shift_px` (2, h, w), u and v, is in pixels of the pinhole picture; `mean_px` is a length in pixels of the delivered
    one; `bands` are rows of it with the longest length in each, those that blur.
    """

    shift_px: NDArray[np.float32]
    mean_px: float
    bands: tuple[tuple[slice, float], ...]


class MotionBlur:
    """One camera's flow from its motion; what depends on the camera alone is computed once."""

    def __init__(self, camera: Camera, pinhole: Camera) -> None:
        self._camera, self._pinhole = camera, pinhole
        self._columns, self._rows = (max(2, size // CELL_PX) for size in (camera.width_px, camera.height_px))
        u, v = np.meshgrid(
            (np.arange(self._columns) + 0.5) / self._columns * camera.width_px,
            (np.arange(self._rows) + 0.5) / self._rows * camera.height_px,
        )
        rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]))
        self._rays: Array = rays / np.linalg.norm(rays, axis=1, keepdims=True)

    def flow(self, pose_world_robot: Pose3, pose_world_camera: Pose3, motion: Motion, shutter_s: float) -> Flow | None:
        """Return how the picture moves while the shutter is open; None where it stays sharp."""
        if not shutter_s or not (motion.v_mps or motion.omega_radps):
            return None
        points = self._points(pose_world_camera)
        pose_robot_camera = pose_world_robot.inverse() @ pose_world_camera
        seen = [
            _as_seen_from(points, pose_robot_camera, moved(motion, time_s).to_pose3())
            for time_s in (-shutter_s / 2, shutter_s / 2)
        ]
        return self._flow(seen[0], seen[1])

    def _points(self, pose_world_camera: Pose3) -> Array:
        """Return what each ray meets (n, 3), in the camera's frame: the floor, or the far wall."""
        height_m = pose_world_camera.translation_m[2]
        down = -self._rays @ pose_world_camera.rotation[2]
        distance_m = np.minimum(height_m / np.maximum(down, height_m / FAR_M), FAR_M)
        points: Array = self._rays * distance_m[:, None]
        return points

    def _flow(self, first: Array, last: Array) -> Flow | None:
        lengths = np.hypot(*(self._camera.project(last) - self._camera.project(first)).T).reshape(self._rows, -1)
        if lengths.max() < SHARP_PX:
            return None
        shift = (self._pinhole.project(last) - self._pinhole.project(first)).astype(np.float32).T
        coarse = shift.reshape(2, self._rows, self._columns)
        size = (self._camera.width_px, self._camera.height_px)
        cell = self._camera.height_px / self._rows
        bands = [
            (slice(round(rows[0] * cell), round((rows[-1] + 1) * cell)), float(lengths[rows].max()))
            for rows in np.array_split(np.arange(self._rows), min(BANDS, self._rows))
        ]
        return Flow(
            shift_px=np.array([cv2.resize(plane, size) for plane in coarse], np.float32),
            mean_px=float(lengths.mean()),
            bands=tuple((rows, longest_px) for rows, longest_px in bands if longest_px > SHARP_PX),
        )


def _as_seen_from(points_camera: Array, pose_robot_camera: Pose3, pose_before_after: Pose3) -> Array:
    """Return points (n, 3) of the resting camera's frame in the frame of the camera that the robot has moved."""
    pose_camera_moved = pose_robot_camera.inverse() @ pose_before_after @ pose_robot_camera
    return pose_camera_moved.inverse().transform(points_camera)
