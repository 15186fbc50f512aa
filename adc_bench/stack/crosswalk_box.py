"""From a detector's box to a first place of the crosswalk on the floor."""

import math

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.crosswalk_pattern import CrosswalkPattern
from adc_bench.world.frame import BoxPx

Array = NDArray[np.float64]

BORDER_PX = 3.0  # a side this near the picture's border may be cut off by it
STEP_M = 0.01
EDGE_STEP_M = 0.1  # a lens bends the edges; a chord this long stays within a tenth of a pixel of them
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
        boxes = _boxes(place + np.eye(3, 2, -1) * STEP_M, road_yaw_rad, pattern, birds_eye)
        if np.isnan(boxes).any():
            return None
        jacobian = (boxes[1:] - boxes[0]).T[inside] / STEP_M
        move = np.linalg.lstsq(jacobian, (wanted - boxes[0])[inside], rcond=None)[0]
        place = place + np.clip(move, -LONGEST_MOVE_M, LONGEST_MOVE_M)
    return Pose2(x_m=float(place[0]), y_m=float(place[1]), yaw_rad=road_yaw_rad)


def _boxes(places: Array, yaw_rad: float, pattern: CrosswalkPattern, birds_eye: BirdsEye) -> Array:
    """Return the boxes (n, 4) round what the picture shows of the pattern at places (n, 2); nan where it shows none.

    What lies outside the picture counts for nothing: the detector has not seen it.
    """
    outline = Pose2(x_m=0.0, y_m=0.0, yaw_rad=yaw_rad).transform(pattern.outline(EDGE_STEP_M))
    points = (places[:, None, :] + outline).reshape(-1, 2)
    pixels = birds_eye.to_pixels(points).reshape(len(places), -1, 2)
    if np.isnan(pixels).any():
        return np.full((len(places), 4), np.nan)
    shown = shapely.clip_by_rect(shapely.polygons(pixels), 0, 0, birds_eye.mount.width_px, birds_eye.mount.height_px)
    return np.asarray(shapely.bounds(shown), dtype=np.float64)
