"""Keypoints: an object's four corners in the picture, and whether they are seen there."""

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Camera
from adc_bench.render.other_ids import OtherId
from adc_bench.render.placed import Placed
from adc_bench.render.targets import CROSSWALK_ID
from adc_bench.world.frame import KEYPOINT_HIDDEN, KEYPOINT_OUTSIDE, KEYPOINT_VISIBLE, NO_KEYPOINTS, KeypointPx

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Geometries = NDArray[np.object_]
# A keypoint is seen if the middle of one of its object's pixels is so near to its anchor.
NEAR_PX = 1.5
# An acute corner may hold no pixel's middle so near. There the nearest point counts that lies so far within the outline
# that its pixel is the object's (0.71 px from point to middle, 0.5 px by which the lens moves ids), if it is not too
# far from the anchor.
WITHIN_PX, ACUTE_PX = 1.25, 10.0
_AROUND = np.stack(np.meshgrid(np.arange(-2, 3), np.arange(-2, 3)), axis=-1).reshape(-1, 2)


def keypoints_of(
    ids: NDArray[np.uint8], seen: Placed, shapes_px: Geometries, camera: Camera
) -> list[tuple[KeypointPx, ...]]:
    """Return the keypoints of each object, given its outline in the picture.

    A keypoint outside the picture or behind the camera is (0, 0, KEYPOINT_OUTSIDE). One in it is visible if the object
    itself is seen at the anchor: the point of its outline nearest to the keypoint. The crosswalk lies on the floor, so
    that the floor beside it will do.
    """
    found = [NO_KEYPOINTS] * len(seen.targets)
    some, points_camera = seen.keypoints()
    corners = camera.project(points_camera.reshape(-1, 3))
    inside = ((corners >= 0) & (corners < (camera.width_px, camera.height_px))).all(axis=1)
    if not inside.any():
        return found
    owner = np.repeat(some, 4)[inside]
    wanted = np.array([target.label_id for target in seen.targets])[owner]
    are_seen = _are_seen(ids, corners[inside], shapes_px[owner], wanted)
    states = np.full(len(corners), KEYPOINT_OUTSIDE)
    states[inside] = np.where(are_seen, KEYPOINT_VISIBLE, KEYPOINT_HIDDEN)
    points = [
        (u, v, state) if state else (0.0, 0.0, KEYPOINT_OUTSIDE)
        for (u, v), state in zip(corners.tolist(), states.tolist(), strict=True)
    ]
    for n, k in enumerate(some):
        found[k] = tuple(points[4 * n : 4 * n + 4])
    return found


def _are_seen(ids: NDArray[np.uint8], corners_px: Array, shapes_px: Geometries, wanted: Integers) -> NDArray[np.bool_]:
    """Return which corners (n, 2) are seen: those of objects with these outlines and label ids, (n,) each."""
    anchors = _nearest(corners_px, shapes_px)
    seen = _is_near(ids, anchors, wanted)
    unsure = np.flatnonzero(~seen & (wanted != CROSSWALK_ID))
    if len(unsure):
        within = _nearest(corners_px[unsure], shapely.buffer(shapes_px[unsure], -WITHIN_PX, join_style="mitre"))
        far = ~(np.hypot(*(within - anchors[unsure]).T) <= ACUTE_PX)
        columns, rows = np.where(far[:, None], 0.0, within).astype(np.int64).T
        seen[unsure] = ~far & (ids[rows, columns] == wanted[unsure])
    return seen


def _nearest(points_px: Array, shapes_px: Geometries) -> Array:
    """Return each shape's point nearest to its point, (n, 2); nan for an empty shape."""
    nearest = np.full(points_px.shape, np.nan)
    some = ~shapely.is_empty(shapes_px)
    lines = shapely.shortest_line(shapely.points(points_px[some]), shapes_px[some])
    nearest[some] = shapely.get_coordinates(lines)[1::2]
    return nearest


def _is_near(ids: NDArray[np.uint8], anchors_px: Array, wanted: Integers) -> NDArray[np.bool_]:
    """Return for anchors (n, 2) whether the middle of a pixel of the wanted id (n,) is near."""
    height, width = ids.shape
    anchors = np.where(np.isnan(anchors_px), -9.0, anchors_px)[:, None]
    pixels = np.floor(anchors).astype(np.int64) + _AROUND
    columns, rows = pixels[..., 0].clip(0, width - 1), pixels[..., 1].clip(0, height - 1)
    across, down = columns + 0.5 - anchors[..., 0], rows + 0.5 - anchors[..., 1]
    near = across * across + down * down <= NEAR_PX**2
    beside = np.where(wanted == CROSSWALK_ID, OtherId.FLOOR, wanted)
    found, either = ids[rows, columns], (wanted[:, None], beside[:, None])
    seen: NDArray[np.bool_] = (near & ((found == either[0]) | (found == either[1]))).any(axis=1)
    return seen
