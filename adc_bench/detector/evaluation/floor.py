"""How far the crosswalk's corners lie from the true ones on the floor: through the camera, in metres."""

from collections.abc import Callable
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.evaluation.corners import FoundCorners
from adc_bench.detector.evaluation.matching import Matches
from adc_bench.detector.evaluation.spread import Spread, spread_of
from adc_bench.geometry import Camera, Pose3

Array = NDArray[np.float64]
RANGES_M = ((0.5, 2.0), (2.0, 4.0), (4.0, 6.0))
SLOPE_MIN = 0.02  # a ray that sinks less than so much a metre is taken to sink so much: it would never meet the floor


class FloorScore(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Distances on the floor in metres, of the corners in one range.

    Attributes:
        found: from the corner found to the true one, both through the camera's true pose.
        found_nominal: from the corner found, through the camera's nominal mount on a level robot, to the true one: what
            a driver gets that knows nothing better.
        nominal: from the true corner through the nominal mount to the true one: what the tilt of camera and body costs
            alone.
    """

    found: Spread
    found_nominal: Spread
    nominal: Spread


@dataclass(frozen=True, kw_only=True, eq=False)
class FloorErrors:
    """Corner by corner, (n,) each: the distance from the point on the floor below the camera, and the three errors."""

    distance_m: Array
    found_m: Array
    found_nominal_m: Array
    nominal_m: Array


def floor_errors(source: LabelledPictures, matches: Matches, crosswalks: FoundCorners) -> FloorErrors:
    """Return the errors of the corners that are seen of the crosswalks found."""
    rows = [np.zeros((0, 4))]
    for label, detection, true_px, seen in zip(*crosswalks, strict=True):
        index = int(matches.label_picture[label])
        mount = source.mount(index)
        camera, true_pose = mount.camera(), _pose(source.pose_world_camera(index))
        nominal_pose = source.pose_world_robot(index).to_pose3() @ mount.pose_robot_camera()
        found_px = matches.keypoints_px[detection][seen]
        true = on_floor(camera, true_pose, true_px[seen])
        away = _between(true)
        rows.append(
            np.column_stack(
                [
                    np.hypot(*(true - true_pose.translation_m[:2]).T),
                    away(on_floor(camera, true_pose, found_px)),
                    away(on_floor(camera, nominal_pose, found_px)),
                    away(on_floor(camera, nominal_pose, true_px[seen])),
                ]
            )
        )
    distance_m, found_m, found_nominal_m, nominal_m = np.concatenate(rows).T
    return FloorErrors(distance_m=distance_m, found_m=found_m, found_nominal_m=found_nominal_m, nominal_m=nominal_m)


def floor_scores(errors: FloorErrors) -> dict[str, FloorScore]:
    """Return the scores by range, named by its ends in metres."""
    return {f"{low:g}-{high:g} m": _score(errors, low, high) for low, high in RANGES_M}


def on_floor(camera: Camera, pose_world_camera: Pose3, pixels_px: ArrayLike) -> Array:
    """Return where the rays through pixels (n, 2) meet the floor z = 0, (n, 2) in the world."""
    rays = camera.rays(pixels_px) @ pose_world_camera.rotation.T
    sinking = np.maximum(-rays[:, 2], SLOPE_MIN * np.hypot(rays[:, 0], rays[:, 1]))
    points: Array = pose_world_camera.translation_m[:2] + rays[:, :2] * (
        pose_world_camera.translation_m[2] / sinking[:, None]
    )
    return points


def _score(errors: FloorErrors, low: float, high: float) -> FloorScore:
    rows = (low <= errors.distance_m) & (errors.distance_m < high)
    return FloorScore(
        found=spread_of(errors.found_m[rows]),
        found_nominal=spread_of(errors.found_nominal_m[rows]),
        nominal=spread_of(errors.nominal_m[rows]),
    )


def _between(true: Array) -> Callable[[Array], Array]:
    return lambda points: np.hypot(*(points - true).T)


def _pose(matrix: Array) -> Pose3:
    return Pose3(rotation=matrix[:3, :3].copy(), translation_m=matrix[:3, 3].copy())
