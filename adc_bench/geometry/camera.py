"""A calibrated camera: x right, y down, z forward; pixel centres at whole numbers plus one half.

The pinhole model with OpenCV's first two radial distortion coefficients (its `k1`, `k2`; the tangential ones are 0).
"""

import math

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from adc_bench.errors import InputError

Array = NDArray[np.float64]

# Columns: the camera's axes (right, down, forward) in a frame with x forward, y left, z up.
ROTATION_BODY_OPTICAL: Array = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
UNDISTORT_STEPS = 12
BORDER_STEPS = 32


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
        """Return the pixels (n, 2) of points (n, 3) in front of the camera (z > 0; others give nan).

        So do points so far aside that the distortion's polynomial would fold them back into the picture.
        """
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

    def border_px(self) -> Array:
        """Return pixels (n, 2) along the picture's border, its corners among them."""
        along, across = np.linspace(0.0, 1.0, BORDER_STEPS + 1), np.zeros(BORDER_STEPS + 1)
        sides = (along, across), (along, across + 1), (across, along), (across + 1, along)
        border: Array = np.concatenate([np.column_stack(side) for side in sides]) * (self.width_px, self.height_px)
        return border

    def covering_pinhole(self) -> "Camera":
        """Return the camera without distortion, of the same focal length, that sees all that this one sees.

        Its picture has an even number of rows and columns and the principal point in its middle. A camera without
        distortion is its own.

        Raises:
            InputError: the distortion folds the picture's border back, so that no pinhole camera covers it.
        """
        if self.k1 == 0.0 == self.k2:
            return self
        border = self.border_px()
        rays = self.rays(border)
        if not np.allclose(self.project(rays), border, atol=1e-3):
            raise InputError(
                where="a camera's lens",
                found=f"k1 = {self.k1}, k2 = {self.k2}, which show one direction twice within the picture",
                wanted="a distortion that grows towards the picture's corners",
                todo="lower k1, raise k2, or narrow the field of view",
            )
        half_u, half_v = np.ceil(np.abs(rays[:, :2]).max(axis=0) * (self.fx_px, self.fy_px) - 1e-9)
        return Camera(
            width_px=2 * int(half_u),
            height_px=2 * int(half_v),
            fx_px=self.fx_px,
            fy_px=self.fy_px,
            cx_px=float(half_u),
            cy_px=float(half_v),
        )

    def _distorted(self, plane: Array) -> Array:
        if self.k1 == 0.0 == self.k2:
            return plane
        square = np.sum(plane**2, axis=1, keepdims=True)
        scale = np.where(square < self._fold_square, 1 + self.k1 * square + self.k2 * square**2, np.nan)
        distorted: Array = plane * scale
        return distorted

    @property
    def _fold_square(self) -> float:
        """The least r^2 from which on s(r) r falls: the first root of its derivative 1 + 3 k1 r^2 + 5 k2 r^4."""
        a, b = 5 * self.k2, 3 * self.k1
        if a == 0:
            return -1 / b if b < 0 else math.inf
        inner = b * b - 4 * a
        if inner < 0:
            return math.inf
        roots = [(-b - math.sqrt(inner)) / (2 * a), (-b + math.sqrt(inner)) / (2 * a)]
        return min((root for root in roots if root > 0), default=math.inf)

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
