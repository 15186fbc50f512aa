"""The bird's-eye view: pixels of a camera on the robot <-> metres on the floor, through the nominal calibration.

Every way goes through the calibrated camera, its lens included.

Floor points are (x ahead, y left) in the robot frame; a floor picture's row 0 is the far edge, column 0 the left one.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.world.sensors import CameraMount

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]
Mask = NDArray[np.bool_]

HORIZON = 1e-9  # a ray that falls less than this per unit of depth meets no floor


@dataclass(frozen=True, kw_only=True)
class FloorRegion:
    """The rectangle of floor that is looked at, cut into square cells."""

    x_near_m: float = 0.5
    x_far_m: float = 3.0
    half_width_m: float = 1.3
    cell_m: float = 0.01

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the floor picture."""
        return round((self.x_far_m - self.x_near_m) / self.cell_m), round(2 * self.half_width_m / self.cell_m)

    def points(self, cells: ArrayLike) -> Array:
        """Return the floor points (n, 2) of cells (n, 2) given as (column, row), whole numbers at cell centres."""
        c = np.asarray(cells, dtype=np.float64)
        x = self.x_far_m - (c[:, 1] + 0.5) * self.cell_m
        y = self.half_width_m - (c[:, 0] + 0.5) * self.cell_m
        return np.stack([x, y], axis=1)

    def cells(self, points_robot: ArrayLike) -> Array:
        """Return the cells (n, 2) as (column, row), not rounded, of floor points (n, 2)."""
        p = np.asarray(points_robot, dtype=np.float64)
        column = (self.half_width_m - p[:, 1]) / self.cell_m - 0.5
        row = (self.x_far_m - p[:, 0]) / self.cell_m - 0.5
        return np.stack([column, row], axis=1)


@dataclass(frozen=True, kw_only=True)
class BirdsEye:
    """A camera's view of the floor, laid out to scale; `tilt_rad` is its known pitch and roll against the mount."""

    mount: CameraMount
    region: FloorRegion = FloorRegion()
    tilt_rad: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def _camera(self) -> Camera:
        return self.mount.camera()

    @cached_property
    def _pose_robot_camera(self) -> Pose3:
        return self.mount.pose_robot_camera(*self.tilt_rad)

    @cached_property
    def _pose_camera_robot(self) -> Pose3:
        return self._pose_robot_camera.inverse()

    @cached_property
    def _cell_indices(self) -> Array:
        """The picture's array indices (rows, columns, 2), not rounded, of every cell; nan behind the camera."""
        rows, columns = self.region.shape
        column, row = np.meshgrid(np.arange(columns), np.arange(rows))
        points = self.region.points(np.stack([column.ravel(), row.ravel()], axis=1))
        # Pixel centres are at whole numbers plus one half, array indices at whole numbers.
        return (self.to_pixels(points) - 0.5).reshape(rows, columns, 2)

    @cached_property
    def _tables(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Columns and rows of the picture at which the cells look, for cv2.remap; outside it, at its border."""
        last = (self.mount.width_px - 1, self.mount.height_px - 1)
        indices = np.clip(np.nan_to_num(self._cell_indices), 0.0, last).astype(np.float32)
        return np.ascontiguousarray(indices[..., 0]), np.ascontiguousarray(indices[..., 1])

    @cached_property
    def seen(self) -> Mask:
        """The cells (rows, columns) inside the picture."""
        limits = np.array([self.mount.width_px, self.mount.height_px]) - 0.5
        return np.asarray(np.all((self._cell_indices > -0.5) & (self._cell_indices < limits), axis=2))

    def grey(self, rgb: NDArray[np.uint8]) -> Grey:
        """Return the floor picture (rows, columns) of a picture (height, width, 3); unseen cells repeat its border."""
        # The blue channel is the noisiest under warm light and JPEG; OpenCV's weights keep it at 11 %.
        grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
        return np.asarray(cv2.remap(grey, *self._tables, cv2.INTER_LINEAR), dtype=np.uint8)

    def to_floor(self, pixels_px: ArrayLike) -> Array:
        """Return the floor points (n, 2) under pixels (n, 2); nan at and above the horizon."""
        pose = self._pose_robot_camera
        rays = self._camera.rays(pixels_px) @ pose.rotation.T
        down = np.where(rays[:, 2] < -HORIZON, -rays[:, 2], np.nan)
        points: Array = pose.translation_m[:2] + rays[:, :2] * (pose.translation_m[2] / down)[:, None]
        return points

    def to_pixels(self, points_robot: ArrayLike) -> Array:
        """Return the pixels (n, 2) of floor points (n, 2); nan behind the camera."""
        points = np.asarray(points_robot, dtype=np.float64)
        pose = self._pose_camera_robot
        return self._camera.project(points @ pose.rotation[:, :2].T + pose.translation_m)

    def tilt_jacobian(self, points_robot: ArrayLike) -> Array:
        """Return (n, 2, 2): how floor points (n, 2) move per radian of unknown camera pitch and roll.

        A point is seen by the tilted camera and laid out by the nominal one. The pixel between them bends both rays
        alike, so the lens drops out: a tilt about an axis a turns the ray v to the point by v x a, and the floor cuts
        the turned ray. Pitch turns about the robot's y axis, roll about the line of sight.
        """
        pose = self._pose_robot_camera
        x, y = (np.asarray(points_robot, dtype=np.float64) - pose.translation_m[:2]).T
        ahead, height = pose.rotation[:, 2], pose.translation_m[2]
        columns = []
        for ax, ay, az in ((0.0, 1.0, 0.0), ahead):
            by_x, by_y, by_z = y * az + height * ay, -height * ax - x * az, x * ay - y * ax
            columns.append(np.stack([by_x + x * by_z / height, by_y + y * by_z / height], axis=1))
        return np.stack(columns, axis=2)
