"""Rigid poses. `pose_<outer>_<inner>` is where inner is, seen from outer; neighbours cancel under `@`."""

import math
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from adc_bench.geometry.angles import wrap_rad

Array = NDArray[np.float64]


class Pose2(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A pose on the floor: metres and radians."""

    x_m: float
    y_m: float
    yaw_rad: float

    def __matmul__(self, inner: "Pose2") -> "Pose2":
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return Pose2(
            x_m=self.x_m + c * inner.x_m - s * inner.y_m,
            y_m=self.y_m + s * inner.x_m + c * inner.y_m,
            yaw_rad=wrap_rad(self.yaw_rad + inner.yaw_rad),
        )

    def inverse(self) -> "Pose2":
        """Return where outer is, seen from inner."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return Pose2(x_m=-c * self.x_m - s * self.y_m, y_m=s * self.x_m - c * self.y_m, yaw_rad=wrap_rad(-self.yaw_rad))

    def transform(self, points_inner: ArrayLike) -> Array:
        """Return the points (n, 2) in the outer frame."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        rotation = np.array([[c, -s], [s, c]])
        points: Array = np.asarray(points_inner, dtype=np.float64) @ rotation.T + (self.x_m, self.y_m)
        return points

    def to_pose3(self) -> "Pose3":
        """Return the same pose in space, on the floor z = 0."""
        return Pose3(rotation=rotation_zyx(self.yaw_rad, 0.0, 0.0), translation_m=np.array([self.x_m, self.y_m, 0.0]))


@dataclass(frozen=True, kw_only=True, eq=False)
class Pose3:
    """A pose in space: rotation (3, 3), translation in metres (3,)."""

    rotation: Array
    translation_m: Array

    def __post_init__(self) -> None:
        assert self.rotation.shape == (3, 3) and self.translation_m.shape == (3,)
        self.rotation.setflags(write=False)
        self.translation_m.setflags(write=False)

    def __matmul__(self, inner: "Pose3") -> "Pose3":
        return Pose3(
            rotation=self.rotation @ inner.rotation,
            translation_m=self.rotation @ inner.translation_m + self.translation_m,
        )

    def inverse(self) -> "Pose3":
        """Return where outer is, seen from inner."""
        return Pose3(rotation=self.rotation.T.copy(), translation_m=-self.rotation.T @ self.translation_m)

    def transform(self, points_inner: ArrayLike) -> Array:
        """Return the points (n, 3) in the outer frame."""
        points: Array = np.asarray(points_inner, dtype=np.float64) @ self.rotation.T + self.translation_m
        return points

    @classmethod
    def from_figures(cls, figures: ArrayLike) -> "Pose3":
        """Return the pose of seven figures: x, y, z in metres and the quaternion x, y, z, w."""
        from scipy.spatial.transform import Rotation  # here: half a second that no submission's process needs

        values = np.asarray(figures, dtype=np.float64)
        return cls(rotation=Rotation.from_quat(values[3:]).as_matrix(), translation_m=values[:3].copy())

    def figures(self) -> tuple[float, float, float, float, float, float, float]:
        """Return x, y, z in metres and the quaternion x, y, z, w (w >= 0)."""
        from scipy.spatial.transform import Rotation

        x, y, z = self.translation_m.tolist()
        qx, qy, qz, qw = Rotation.from_matrix(self.rotation).as_quat(canonical=True).tolist()
        return x, y, z, qx, qy, qz, qw

    def matrix(self) -> Array:
        """Return the homogeneous matrix (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self.rotation, self.translation_m
        return matrix


def rotation_zyx(yaw_rad: float, pitch_rad: float, roll_rad: float) -> Array:
    """Return Rz(yaw) Ry(pitch) Rx(roll), (3, 3). With x forward and z up, positive pitch looks down."""
    cz, sz = math.cos(yaw_rad), math.sin(yaw_rad)
    rz = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    if pitch_rad == 0.0 == roll_rad:
        return rz
    cy, sy = math.cos(pitch_rad), math.sin(pitch_rad)
    cx, sx = math.cos(roll_rad), math.sin(roll_rad)
    ry = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    rx = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    rotation: Array = rz @ ry @ rx
    return rotation
