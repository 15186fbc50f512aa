"""Robust least squares for shapes on the floor, with the camera's unknown tilt as a nuisance."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.stack.birds_eye import BirdsEye

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class FitNoise:
    """What makes a floor point uncertain.

    Attributes:
        pixel_sd_px: of a line's middle in the picture, worst along the view, where a pixel covers most floor.
        floor_sd_m: what no picture resolves: uneven paint, rounded windows.
        tilt_sd_rad: of camera pitch and roll against the nominal mount, the body's own nodding included.
        huber: residuals beyond this many standard deviations count linearly.
    """

    pixel_sd_px: float = 0.5
    floor_sd_m: float = 0.006
    tilt_sd_rad: float = math.radians(0.4)
    huber: float = 2.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """The shape's parameters (k,), their covariance (k, k), the camera tilt [pitch, roll] that fits best, and the
    weighted root mean square of the residuals in standard deviations.
    """

    parameters: Array
    covariance: Array
    tilt_rad: Array
    rms: float


Model = Callable[[Array], tuple[Array, Array, Array]]
"""parameters (k,) -> residuals (n,) in metres, their Jacobian (n, k), and the unit normals (n, 2) along which a
displaced point changes its residual."""


def fit_shape(
    model: Model,
    start: Array,
    points_robot: Array,
    birds_eye: BirdsEye,
    noise: FitNoise,
    *,
    iterations: int = 6,
) -> Fit:
    """Return the shape nearest to points (n, 2): Gauss-Newton with Huber weights over shape and tilt together.

    Carrying the tilt (with its prior) makes the covariance honest: points that a tilt would displace weigh less.
    """
    k = len(start)
    sd = point_sd_m(points_robot, birds_eye, noise)
    by_tilt = birds_eye.tilt_jacobian(points_robot)
    unknowns = np.concatenate([start, np.zeros(2)])
    prior = np.diag([*np.zeros(k), *np.full(2, noise.tilt_sd_rad**-2)])
    for _ in range(iterations):
        residuals, jacobian, normals = model(unknowns[:k])
        # The true point is the seen one less what the tilt displaced it by.
        tilt_columns = -np.einsum("ni,nij->nj", normals, by_tilt)
        whole = np.column_stack([jacobian, tilt_columns]) / sd[:, None]
        left = (residuals + tilt_columns @ unknowns[k:]) / sd
        weights = np.minimum(1.0, noise.huber / np.maximum(np.abs(left), 1e-12))
        information = whole.T @ (whole * weights[:, None]) + prior
        unknowns = unknowns - np.linalg.solve(information, whole.T @ (weights * left) + prior @ unknowns)
    return Fit(
        parameters=unknowns[:k],
        covariance=np.linalg.inv(information)[:k, :k],
        tilt_rad=unknowns[k:],
        rms=float(np.sqrt(np.mean(weights * left**2))),
    )


def point_sd_m(points_robot: Array, birds_eye: BirdsEye, noise: FitNoise) -> Array:
    """Return (n,) standard deviations: floor covered by the pixel noise along the view, and the floor's own."""
    mount = birds_eye.mount
    ahead = np.hypot(points_robot[:, 0] - mount.x_m, points_robot[:, 1])
    metres_per_px = (ahead**2 + mount.z_m**2) / (mount.z_m * mount.camera().fx_px)
    sd: Array = np.hypot(noise.pixel_sd_px * metres_per_px, noise.floor_sd_m)
    return sd
