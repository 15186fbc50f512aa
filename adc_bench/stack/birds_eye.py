"""The bird's-eye view: pixels of a camera on the robot <-> metres on the floor, through the nominal calibration.

Floor points are (x ahead, y left) in the robot frame; a floor picture's row 0 is the far edge, column 0 the left one.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from adc_bench.world.sensors import CameraMount

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]
Mask = NDArray[np.bool_]


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
    """A camera's view of the floor, laid out to scale."""

    mount: CameraMount
    region: FloorRegion = FloorRegion()

    @cached_property
    def _pixel_from_floor(self) -> Array:
        return floor_homography(self.mount)

    @cached_property
    def _pixel_from_cell(self) -> Array:
        """Homography from (column, row) to the picture's array indices, for cv2.warpPerspective."""
        r = self.region
        floor_from_cell = np.array(
            [
                [0.0, -r.cell_m, r.x_far_m - r.cell_m / 2],
                [-r.cell_m, 0.0, r.half_width_m - r.cell_m / 2],
                [0.0, 0.0, 1.0],
            ]
        )
        # Pixel centres are at whole numbers plus one half, array indices at whole numbers.
        index_from_pixel = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
        homography: Array = index_from_pixel @ self._pixel_from_floor @ floor_from_cell
        return homography

    @cached_property
    def seen(self) -> Mask:
        """The cells (rows, columns) inside the picture."""
        whole = np.full((self.mount.height_px, self.mount.width_px), 255, dtype=np.uint8)
        rows, columns = self.region.shape
        flags = cv2.WARP_INVERSE_MAP | cv2.INTER_NEAREST
        return cv2.warpPerspective(whole, self._pixel_from_cell, (columns, rows), flags=flags) > 0

    def grey(self, rgb: NDArray[np.uint8]) -> Grey:
        """Return the floor picture (rows, columns) of a picture (height, width, 3); unseen cells repeat its border."""
        # The blue channel is the noisiest under warm light and JPEG; OpenCV's weights keep it at 11 %.
        grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
        rows, columns = self.region.shape
        flags = cv2.WARP_INVERSE_MAP | cv2.INTER_LINEAR
        floor = cv2.warpPerspective(
            grey, self._pixel_from_cell, (columns, rows), flags=flags, borderMode=cv2.BORDER_REPLICATE
        )
        return np.asarray(floor, dtype=np.uint8)

    def to_floor(self, pixels_px: ArrayLike) -> Array:
        """Return the floor points (n, 2) under pixels (n, 2); nan at and above the horizon."""
        return _apply(self._floor_from_pixel, pixels_px, scale_sign=self._floor_side)

    def to_pixels(self, points_robot: ArrayLike) -> Array:
        """Return the pixels (n, 2) of floor points (n, 2); nan behind the camera."""
        return _apply(self._pixel_from_floor, points_robot, scale_sign=1.0)

    @cached_property
    def _floor_from_pixel(self) -> Array:
        return np.asarray(np.linalg.inv(self._pixel_from_floor), dtype=np.float64)

    @cached_property
    def _floor_side(self) -> float:
        """Sign of the inverse homography's scale for pixels below the horizon."""
        below = np.array([self.mount.width_px / 2, 1e6, 1.0])
        return float(np.sign((self._floor_from_pixel @ below)[2]))

    def tilt_jacobian(self, points_robot: ArrayLike) -> Array:
        """Return (n, 2, 2): how floor points (n, 2) move per radian of unknown camera pitch and roll.

        Central differences through the exact homographies: a point is seen by the tilted camera and laid out by the
        nominal one.
        """
        step = 1e-5
        columns = []
        for pitch, roll in ((step, 0.0), (0.0, step)):
            ahead = self.to_floor(_apply(floor_homography(self.mount, pitch, roll), points_robot, scale_sign=1.0))
            behind = self.to_floor(_apply(floor_homography(self.mount, -pitch, -roll), points_robot, scale_sign=1.0))
            columns.append((ahead - behind) / (2 * step))
        return np.stack(columns, axis=2)


def floor_homography(mount: CameraMount, pitch_error_rad: float = 0.0, roll_error_rad: float = 0.0) -> Array:
    """Return H (3, 3), pixel ~ H (x, y, 1) for floor points in the robot frame: K [r1 r2 t] of pose_camera_robot."""
    camera_robot = mount.pose_robot_camera(pitch_error_rad, roll_error_rad).inverse().matrix()
    homography: Array = mount.camera().matrix() @ camera_robot[:3][:, [0, 1, 3]]
    return homography


def _apply(homography: Array, points: ArrayLike, scale_sign: float) -> Array:
    p = np.asarray(points, dtype=np.float64)
    q = p @ homography[:, :2].T + homography[:, 2]
    scale = np.where(q[:, 2] * scale_sign > 1e-12, q[:, 2], np.nan)
    result: Array = q[:, :2] / scale[:, None]
    return result
