"""The pinhole camera: x right, y down, z forward; pixel centres at whole numbers plus one half."""

import math

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Columns: the camera's axes (right, down, forward) in a frame with x forward, y left, z up.
ROTATION_BODY_OPTICAL: Array = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


class Camera(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Intrinsics of a pinhole camera in pixels: u = fx x/z + cx, v = fy y/z + cy."""

    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float

    @classmethod
    def from_hfov(cls, *, width_px: int, height_px: int, hfov_rad: float) -> "Camera":
        """Return the camera with square pixels and a centred principal point."""
        f_px = width_px / 2 / math.tan(hfov_rad / 2)
        return cls(
            width_px=width_px,
            height_px=height_px,
            fx_px=f_px,
            fy_px=f_px,
            cx_px=width_px / 2,
            cy_px=height_px / 2,
        )

    def matrix(self) -> Array:
        """Return K, (3, 3)."""
        return np.array([[self.fx_px, 0.0, self.cx_px], [0.0, self.fy_px, self.cy_px], [0.0, 0.0, 1.0]])

    def project(self, points_camera: ArrayLike) -> Array:
        """Return the pixels (n, 2) of points (n, 3) in front of the camera (z > 0; others give nan)."""
        points = np.asarray(points_camera, dtype=np.float64)
        z = np.where(points[:, 2] > 0, points[:, 2], np.nan)
        return np.stack(
            [self.fx_px * points[:, 0] / z + self.cx_px, self.fy_px * points[:, 1] / z + self.cy_px], axis=1
        )

    def rays(self, pixels_px: ArrayLike) -> Array:
        """Return the directions (n, 3) with z = 1 through pixels (n, 2)."""
        pixels = np.asarray(pixels_px, dtype=np.float64)
        x = (pixels[:, 0] - self.cx_px) / self.fx_px
        y = (pixels[:, 1] - self.cy_px) / self.fy_px
        return np.stack([x, y, np.ones_like(x)], axis=1)
