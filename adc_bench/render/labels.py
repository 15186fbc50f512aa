"""Labels from the picture of label ids, and what the whole object would look like from its known shape."""

from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render.targets import Target
from adc_bench.world.frame import BoxPx, Label

Array = NDArray[np.float64]
NEAR_M = 0.02
# Below these an object is an ignore region: pixels at 320 x 240 (they grow with the picture), and visible share.
VISIBLE_PX_MIN = 40
VISIBLE_FRACTION_MIN = 0.2
# A distorted edge is drawn through so many points a picture width; its error is then below 0.1 px.
EDGE_POINTS = 32


def labels_of(
    ids: NDArray[np.uint8], targets: Sequence[Target], camera: Camera, pose_world_camera: Pose3
) -> tuple[Label, ...]:
    """Return the labels of every target with at least one visible pixel and its front towards the camera.

    `ids` (h, w) holds the label ids of the delivered picture, that is: seen through the distorting lens.
    """
    counts = cv2.calcHist([ids], [0], None, [256], [0, 256]).ravel()  # in a fifth of the time of a bincount
    pose_camera_world = pose_world_camera.inverse()
    labels = []
    for target in targets:
        if visible_px := int(counts[target.label_id]):
            pose_camera_object = pose_camera_world @ target.pose_world_object
            if _shows_front(target, pose_camera_object):
                labels.append(_label(ids == target.label_id, visible_px, target, camera, pose_camera_object))
    return tuple(labels)


def _shows_front(target: Target, pose_camera_object: Pose3) -> bool:
    if target.front is None:
        return True
    eye = pose_camera_object.inverse().translation_m
    return float((eye - target.faces[0][0]) @ target.front) > 0.0


def _label(mask: NDArray[np.bool_], visible_px: int, target: Target, camera: Camera, pose: Pose3) -> Label:
    faces_camera = [pose.transform(face) for face in target.faces]
    outline, truncation = amodal_outline(faces_camera, camera)
    box = tight_box(mask)
    fraction = min(1.0, visible_px / max(outline.area, 1.0))
    small = visible_px < VISIBLE_PX_MIN * (camera.width_px * camera.height_px) / (320 * 240)
    corners = np.concatenate(faces_camera)
    return Label(
        category_id=target.category_id,
        instance=target.instance,
        box_px=box,
        amodal_box_px=_within_picture(outline.bounds, camera) if outline.area else box,
        visible_px=visible_px,
        visible_fraction=fraction,
        truncation=truncation,
        distance_m=float(np.linalg.norm(corners.mean(axis=0))),
        ignore=small or fraction < VISIBLE_FRACTION_MIN,
    )


def tight_box(mask: NDArray[np.bool_]) -> BoxPx:
    """Return x0, y0, x1, y1 around the true pixels of a mask (h, w) that has some; borders, not centres."""
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    return float(x), float(y), float(x + width), float(y + height)


def _within_picture(box: BoxPx, camera: Camera) -> BoxPx:
    """Return the box without what sticks out because the picture's border was undistorted and distorted again."""
    x0, y0, x1, y1 = box
    return max(0.0, x0), max(0.0, y0), min(float(camera.width_px), x1), min(float(camera.height_px), y1)


def amodal_outline(faces_camera: Sequence[Array], camera: Camera) -> tuple[shapely.Geometry, float]:
    """Return the outline in pixels, clipped to the picture, of the convex pieces (n, 3) as if nothing hid them, and
    the share of it that lies outside the picture.

    The share is one of areas as a lens without distortion would show them: a lens model says nothing about what lies
    far outside the picture.
    """
    pieces = [_seen_flat(_before_near(face)) for face in faces_camera]
    whole = pieces[0] if len(pieces) == 1 else shapely.union_all(pieces)
    field = _field(camera)
    inside = whole if field.contains_properly(whole) else whole.intersection(field)
    if inside.is_empty:
        return inside, 1.0
    truncation = max(0.0, 1.0 - inside.area / whole.area) if whole.area else 0.0
    if camera.k1 or camera.k2:
        inside = inside.segmentize(camera.width_px / camera.fx_px / EDGE_POINTS)
    return shapely.transform(inside, lambda plane: camera.project(_at_one_metre(plane))), truncation


def _at_one_metre(plane: Array) -> Array:
    return np.column_stack([plane, np.ones(len(plane))])


@lru_cache(maxsize=16)
def _field(camera: Camera) -> shapely.Polygon:
    """Return the picture's border in the plane z = 1 before the camera."""
    frame = shapely.box(0.0, 0.0, camera.width_px, camera.height_px)
    border = shapely.get_coordinates(shapely.segmentize(frame, camera.width_px / EDGE_POINTS))
    field = shapely.Polygon(camera.rays(border)[:, :2])
    shapely.prepare(field)
    return field


def _seen_flat(corners: Array) -> shapely.Geometry:
    """Return the convex piece's outline in the plane z = 1, from corners (n, 3) before the camera."""
    if len(corners) < 3:
        return shapely.Polygon()
    line: shapely.LineString = shapely.linestrings(corners[:, :2] / corners[:, 2:])
    return line.convex_hull


def _before_near(corners: Array) -> Array:
    """Return corners (m, 3) of what of a convex piece lies before the near plane; m may be 0."""
    near = corners[:, 2] > NEAR_M
    if near.all():
        return corners
    before, behind = corners[near][:, None], corners[~near][None]
    share = (NEAR_M - before[..., 2]) / (behind[..., 2] - before[..., 2])
    cut = (before + share[..., None] * (behind - before)).reshape(-1, 3)
    return np.concatenate([corners[near], cut])
