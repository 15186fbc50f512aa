"""From a detector's box to a first place of the crosswalk on the floor."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.crosswalk_pattern import CrosswalkPattern
from adc_bench.world.frame import BoxPx

Array = NDArray[np.float64]

BORDER_PX = 3.0  # a side this near the picture's border may be cut off by it
STEP_M = 0.01
LONGEST_MOVE_M = 0.3


def place_of_box(box_px: BoxPx, road_yaw_rad: float, pattern: CrosswalkPattern, birds_eye: BirdsEye) -> Pose2 | None:
    """Return the pose (robot frame) whose outline has this box: least squares over the sides inside the picture.

    None where the near side, or both ends, are cut off by the picture's border, or the box is not on the floor.
    """
    limits = np.array([birds_eye.mount.width_px, birds_eye.mount.height_px]) - BORDER_PX
    wanted = np.array(box_px)
    inside = np.concatenate([wanted[:2] > BORDER_PX, wanted[2:] < limits])
    near = birds_eye.to_floor([((box_px[0] + box_px[2]) / 2, box_px[3])])[0]
    if not (inside[3] and (inside[0] or inside[2])) or np.isnan(near).any():
        return None
    place = near + pattern.half_size_m[0] * np.array([math.cos(road_yaw_rad), math.sin(road_yaw_rad)])
    for _ in range(6):
        boxes = np.stack([_box(place + step, road_yaw_rad, pattern, birds_eye) for step in np.eye(3, 2, -1) * STEP_M])
        if np.isnan(boxes).any():
            return None
        jacobian = (boxes[1:] - boxes[0]).T[inside] / STEP_M
        move = np.linalg.lstsq(jacobian, (wanted - boxes[0])[inside], rcond=None)[0]
        place = place + np.clip(move, -LONGEST_MOVE_M, LONGEST_MOVE_M)
    return Pose2(x_m=float(place[0]), y_m=float(place[1]), yaw_rad=road_yaw_rad)


def _box(place: Array, yaw_rad: float, pattern: CrosswalkPattern, birds_eye: BirdsEye) -> Array:
    """Return the box (4,) around what the picture shows of the pattern's outline at a place; nan where it shows none.

    A corner outside the picture counts for nothing: the detector has not seen it.
    """
    pose = Pose2(x_m=float(place[0]), y_m=float(place[1]), yaw_rad=yaw_rad)
    outline = birds_eye.to_pixels(pose.transform(pattern.corners[[0, 1, 3, 2]]))
    width, height = birds_eye.mount.width_px, birds_eye.mount.height_px
    frame = np.array([[0, 0], [width, 0], [width, height], [0, height]], dtype=np.float32)
    if np.isnan(outline).any():
        return np.full(4, np.nan)
    area, shown = cv2.intersectConvexConvex(frame, outline.astype(np.float32))
    if area <= 0 or shown is None:
        return np.full(4, np.nan)
    points = np.asarray(shown, dtype=np.float64).reshape(-1, 2)
    return np.concatenate([points.min(axis=0), points.max(axis=0)])
