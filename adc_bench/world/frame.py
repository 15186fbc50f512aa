"""Frames with their truth, and what a detector says about a picture."""

from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2, Pose3

BoxPx = tuple[float, float, float, float]  # x0, y0, x1, y1 in pixels


class Label(msgspec.Struct, frozen=True, kw_only=True):
    """One labelled object in one picture.

    `box_px` is tight around the visible pixels; `amodal_box_px` is the projection of the whole object, clipped to the
    picture; `visible_fraction` is visible pixels over the pixels the object would have inside the picture with nothing
    before it; `truncation` is the share of the whole projection's area outside the picture, areas as a lens without
    distortion would show them; `distance_m` is from the camera to the mean of the object's corners.
    """

    category_id: int
    instance: str
    box_px: BoxPx
    amodal_box_px: BoxPx
    visible_px: int
    visible_fraction: float
    truncation: float
    distance_m: float
    ignore: bool


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
    """A delivered picture with its truth. Never handed to a submission."""

    index: int
    camera: str
    jpeg: bytes
    width_px: int
    height_px: int
    pose_world_robot: Pose2
    pose_world_camera: Pose3
    labels: tuple[Label, ...]
    conditions: Conditions


@dataclass(frozen=True, kw_only=True, eq=False)
class Detections:
    """A detector's answer for one picture: boxes_px (n, 4) xyxy, scores (n,), category_ids (n,), best first."""

    boxes_px: NDArray[np.float32]
    scores: NDArray[np.float32]
    category_ids: NDArray[np.int64]
