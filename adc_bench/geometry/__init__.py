"""Angles, poses, cameras and plane curves, on numpy alone."""

from adc_bench.geometry.angles import wrap_array_rad, wrap_rad
from adc_bench.geometry.camera import ROTATION_BODY_OPTICAL, Camera
from adc_bench.geometry.path import Path, Piece, arc, line
from adc_bench.geometry.pose import Pose2, Pose3, rotation_zyx

__all__ = [
    "ROTATION_BODY_OPTICAL",
    "Camera",
    "Path",
    "Piece",
    "Pose2",
    "Pose3",
    "arc",
    "line",
    "rotation_zyx",
    "wrap_array_rad",
    "wrap_rad",
]
