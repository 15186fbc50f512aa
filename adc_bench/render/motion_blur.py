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
CELL_PX = 32  # the flow is computed once in so many pixels each way
SHARP_PX = 0.7  # a picture that moves less is left as it is
Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Flow:
    """How a picture moves over one exposure, in its pixels: u and v (2, h, w), and the mean and the longest length."""

    shift_px: NDArray[np.float32]
    mean_px: float
    longest_px: float


class MotionBlur:
    """One camera's flow from its motion; what depends on the camera alone is computed once."""

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
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
        shift = self._camera.project(last) - self._camera.project(first)
        lengths = np.hypot(shift[:, 0], shift[:, 1])
        if lengths.max() < SHARP_PX:
            return None
        coarse = shift.T.astype(np.float32).reshape(2, self._rows, self._columns)
        size = (self._camera.width_px, self._camera.height_px)
        return Flow(
            shift_px=np.array([cv2.resize(plane, size) for plane in coarse], np.float32),
            mean_px=float(lengths.mean()),
            longest_px=float(lengths.max()),
        )


def _as_seen_from(points_camera: Array, pose_robot_camera: Pose3, pose_before_after: Pose3) -> Array:
    """Return points (n, 3) of the resting camera's frame in the frame of the camera that the robot has moved."""
    pose_camera_moved = pose_robot_camera.inverse() @ pose_before_after @ pose_robot_camera
    return pose_camera_moved.inverse().transform(points_camera)
