"""Frames with their truth, and what a detector says about a picture."""

from dataclasses import dataclass, fields

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2, Pose3
from adc_bench.world.robot import Motion

BoxPx = tuple[float, float, float, float]  # x0, y0, x1, y1 in pixels
KeypointPx = tuple[float, float, int]  # u, v in pixels, and one of the three below
KEYPOINT_OUTSIDE, KEYPOINT_HIDDEN, KEYPOINT_VISIBLE = 0, 1, 2  # outside the picture, in it but hidden, seen (COCO's v)
NO_KEYPOINTS: tuple[KeypointPx, ...] = 4 * ((0.0, 0.0, KEYPOINT_OUTSIDE),)


class Label(msgspec.Struct, frozen=True, kw_only=True):
    """One labelled object in one picture.

    Attributes:
        box_px: tight around the visible pixels.
        amodal_box_px: the projection of the whole object, clipped to the picture.
        amodal_box_whole_px: the same, not clipped but one picture's size beyond each border.
        mask_rle: the visible pixels as COCO's compressed run lengths.
        visible_fraction: visible pixels over those that the object would have in the picture with nothing before it.
        truncation: share of the whole projection's area outside the picture, areas as a lens without distortion would
            show them.
        distance_m: from the camera to the mean of the object's corners.
        pose_world_object: x, y, z in metres and the quaternion x, y, z, w.
        keypoints_px: the four corners. Of the crosswalk in the course's order (-x -y, +x -y, +x +y, -x +y), of a board
            the corners of the square or rectangle around what is shown, from the top left clockwise as seen from the
            front. Boxes and cones have none: `NO_KEYPOINTS`.
        ignore: too small or too hidden to be asked for (see `render/labels.py`).
    """

    category_id: int
    instance: str
    box_px: BoxPx
    amodal_box_px: BoxPx
    amodal_box_whole_px: BoxPx
    mask_rle: bytes
    visible_px: int
    visible_fraction: float
    truncation: float
    distance_m: float
    pose_world_object: tuple[float, float, float, float, float, float, float]
    keypoints_px: tuple[KeypointPx, ...]
    ignore: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class LaneLine:
    """A stretch of a painted line that lies within the picture.

    Attributes:
        name: `outer`, `bulge`, `drop_east`, `drop_west` (solid), `centre_east`, `centre_west`, `bulge_dashes` (dashed).
        points_px: (n, 2) along the line's middle, in the delivered picture.
        points_world: (n, 2) the same points on the floor, in metres.
        visible: (n,) whether nothing stands before the point.
    """

    name: str
    points_px: NDArray[np.float32]
    points_world: NDArray[np.float32]
    visible: NDArray[np.bool_]


class Conditions(msgspec.Struct, frozen=True, kw_only=True):
    """Under what circumstances a picture was taken.

    `shutter_s` is the exposure time, `blur_px` how far the picture moved meanwhile, on average over the picture.
    """

    scenario: str
    look_id: str
    light_level: str
    illuminance_lux: float
    exposure: float
    shutter_s: float
    blur_px: float
    in_tunnel: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Frame:
    """A delivered picture with its truth. Never handed to a submission.

    `depth_m` (h, w) float32 is the distance along the camera's axis, `semantic` (h, w) uint8 the class of each pixel;
    both only where asked for.
    """

    index: int
    camera: str
    jpeg: bytes
    width_px: int
    height_px: int
    pose_world_robot: Pose2
    pose_world_camera: Pose3
    motion: Motion
    labels: tuple[Label, ...]
    lane_lines: tuple[LaneLine, ...]
    conditions: Conditions
    depth_m: NDArray[np.float32] | None = None
    semantic: NDArray[np.uint8] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Detections:
    """A detector's answer for one picture, best first.

    Attributes:
        boxes_px: (n, 4) xyxy.
        scores: (n,) how likely each is right.
        category_ids: (n,) from 1.
        keypoints_px: (n, 4, 2) the corners, from the top left clockwise as they are seen: of a board as its labels have
            them; of the crosswalk far left, far right, near right, near left of who looks at it.
        keypoint_sigma_px: (n, 4) the standard deviation along u and along v that each corner is said to have.
        keypoint_scores: (n, 4) how likely each corner is in the picture and seen. Near 0 for boxes and cones.
    """

    boxes_px: NDArray[np.float32]
    scores: NDArray[np.float32]
    category_ids: NDArray[np.int64]
    keypoints_px: NDArray[np.float32]
    keypoint_sigma_px: NDArray[np.float32]
    keypoint_scores: NDArray[np.float32]

    def of(self, chosen: NDArray[np.bool_]) -> "Detections":
        """Return some of them."""
        return Detections(**{field.name: getattr(self, field.name)[chosen] for field in fields(self)})
