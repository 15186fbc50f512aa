"""A calibrated camera: x right, y down, z forward; pixel centres at whole numbers plus one half.

The pinhole model with OpenCV's first two radial distortion coefficients (its `k1`, `k2`; the tangential ones are 0).
"""

import math

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Columns: the camera's axes (right, down, forward) in a frame with x forward, y left, z up.
ROTATION_BODY_OPTICAL: Array = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
UNDISTORT_STEPS = 12


class Camera(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Intrinsics in pixels: u = fx s x/z + cx, v = fy s y/z + cy; s = 1 + k1 r^2 + k2 r^4, r^2 = (x/z)^2 + (y/z)^2."""

    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    k1: float = 0.0
    k2: float = 0.0

    @classmethod
    def from_hfov(cls, *, width_px: int, height_px: int, hfov_rad: float, k1: float = 0.0, k2: float = 0.0) -> "Camera":
        """Return the camera with square pixels and a centred principal point.

        `hfov_rad` fixes the focal length as without distortion; a barrel distortion (k1 < 0) sees a little more.
        """
        f_px = width_px / 2 / math.tan(hfov_rad / 2)
        return cls(
            width_px=width_px,
            height_px=height_px,
            fx_px=f_px,
            fy_px=f_px,
            cx_px=width_px / 2,
            cy_px=height_px / 2,
            k1=k1,
            k2=k2,
        )

    def matrix(self) -> Array:
        """Return K, (3, 3)."""
        return np.array([[self.fx_px, 0.0, self.cx_px], [0.0, self.fy_px, self.cy_px], [0.0, 0.0, 1.0]])

    def project(self, points_camera: ArrayLike) -> Array:
        """Return the pixels (n, 2) of points (n, 3) in front of the camera (z > 0; others give nan)."""
        points = np.asarray(points_camera, dtype=np.float64)
        z = np.where(points[:, 2] > 0, points[:, 2], np.nan)
        plane = self._distorted(points[:, :2] / z[:, None])
        pixels: Array = plane * (self.fx_px, self.fy_px) + (self.cx_px, self.cy_px)
        return pixels

    def rays(self, pixels_px: ArrayLike) -> Array:
        """Return the directions (n, 3) with z = 1 through pixels (n, 2)."""
        pixels = np.asarray(pixels_px, dtype=np.float64)
        plane = self._undistorted((pixels - (self.cx_px, self.cy_px)) / (self.fx_px, self.fy_px))
        return np.column_stack([plane, np.ones(len(plane))])

    def _distorted(self, plane: Array) -> Array:
        if self.k1 == 0.0 == self.k2:
            return plane
        square = np.sum(plane**2, axis=1, keepdims=True)
        distorted: Array = plane * (1 + self.k1 * square + self.k2 * square**2)
        return distorted

    def _undistorted(self, distorted: Array) -> Array:
        """Solve s(r) r = r' by Newton's method; r grows with r' over the whole picture for any lens worth having."""
        if self.k1 == 0.0 == self.k2:
            return distorted
        wanted = np.hypot(distorted[:, 0], distorted[:, 1])
        radius = wanted.copy()
        for _ in range(UNDISTORT_STEPS):
            square = radius**2
            error = radius * (1 + self.k1 * square + self.k2 * square**2) - wanted
            radius -= error / (1 + 3 * self.k1 * square + 5 * self.k2 * square**2)
        scale = np.divide(radius, wanted, out=np.ones_like(radius), where=wanted > 0)
        plane: Array = distorted * scale[:, None]
        return plane
