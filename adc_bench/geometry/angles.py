"""Angles in radians."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def wrap_rad(angle_rad: float) -> float:
    """Return the angle in [-pi, pi)."""
    return (angle_rad + np.pi) % (2 * np.pi) - np.pi


def wrap_array_rad(angles_rad: ArrayLike) -> NDArray[np.float64]:
    """Return the angles, of any shape, in [-pi, pi)."""
    wrapped: NDArray[np.float64] = (np.asarray(angles_rad, dtype=np.float64) + np.pi) % (2 * np.pi) - np.pi
    return wrapped
