"""Keypoints: an object's four corners in the picture, and whether they are seen there."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render.targets import Target
from adc_bench.world.frame import KEYPOINT_HIDDEN, KEYPOINT_OUTSIDE, KEYPOINT_VISIBLE, NO_KEYPOINTS, KeypointPx

Array = NDArray[np.float64]
# A keypoint is seen if a pixel of its object has its middle so near to the anchor, in pixels.
NEAR_PX = 1.5
_AROUND = np.stack(np.meshgrid(np.arange(-2, 3), np.arange(-2, 3)), axis=-1).reshape(-1, 2)


def keypoints_of(
    ids: NDArray[np.uint8], seen: Sequence[tuple[Target, Pose3]], camera: Camera
) -> list[tuple[KeypointPx, ...]]:
    """Return the keypoints of each object, given where it is in the camera's frame.

    A keypoint outside the picture or behind the camera is (0, 0, KEYPOINT_OUTSIDE). One in it is visible if the object
    itself is seen at the anchor: the point of its outline nearest to the keypoint.
    """
    some = [k for k, (target, _) in enumerate(seen) if target.keypoints is not None]
    found = [NO_KEYPOINTS] * len(seen)
    if some:
        points = [seen[k][1].transform(seen[k][0].keypoints_and_anchors) for k in some]
        pixels = camera.project(np.concatenate(points)).reshape(len(some), 2, 4, 2)
        ids_wanted = np.array([seen[k][0].label_id for k in some])
        corners, visible = pixels[:, 0], _is_seen(ids, pixels[:, 1], ids_wanted)
        inside = ((corners >= 0) & (corners < (camera.width_px, camera.height_px))).all(axis=-1)
        state = np.where(visible, KEYPOINT_VISIBLE, KEYPOINT_HIDDEN) * inside
        for k, places, states in zip(some, corners.tolist(), state.tolist(), strict=True):
            found[k] = tuple(
                (u, v, how) if how else (0.0, 0.0, KEYPOINT_OUTSIDE) for (u, v), how in zip(places, states, strict=True)
            )
    return found


def _is_seen(ids: NDArray[np.uint8], anchors_px: Array, wanted: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return for anchors (n, 4, 2) of n objects whether a pixel near them has the object's id."""
    height, width = ids.shape
    anchors = np.nan_to_num(anchors_px, nan=-np.inf).clip(-9.0, (width + 9.0, height + 9.0))[:, :, None]
    pixels = np.floor(anchors).astype(np.int64) + _AROUND
    near = (np.square(pixels + 0.5 - anchors).sum(axis=-1) <= NEAR_PX**2) & (pixels >= 0).all(axis=-1)
    near &= (pixels < (width, height)).all(axis=-1)
    columns, rows = pixels[..., 0].clip(0, width - 1), pixels[..., 1].clip(0, height - 1)
    seen: NDArray[np.bool_] = (near & (ids[rows, columns] == wanted[:, None, None])).any(axis=-1)
    return seen
