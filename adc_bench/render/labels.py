"""Labels from the picture of label ids, and what the whole object would look like from its known shape."""

from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
import pycocotools.mask
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render.targets import Target
from adc_bench.world.frame import NO_KEYPOINTS, BoxPx, KeypointPx, Label

Array = NDArray[np.float64]
Geometries = NDArray[np.object_]
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
    visible = ((target, pose_camera_world @ target.pose_world_object) for target in targets if counts[target.label_id])
    seen = [(target, pose) for target, pose in visible if _shows_front(target, pose)]
    faces_camera = [[pose.transform(face) for face in target.faces] for target, pose in seen]
    outlines, truncations = amodal_outlines(faces_camera, camera)
    areas, bounds = shapely.area(outlines), shapely.bounds(outlines)
    small_px = VISIBLE_PX_MIN * (camera.width_px * camera.height_px) / (320 * 240)
    labels = []
    for k, (target, _) in enumerate(seen):
        box, visible_px = tight_box(ids == target.label_id), int(counts[target.label_id])
        fraction = min(1.0, visible_px / max(float(areas[k]), 1.0))
        labels.append(
            Label(
                category_id=target.category_id,
                instance=target.instance,
                box_px=box,
                amodal_box_px=_within_picture(bounds[k], camera) if areas[k] else box,
                amodal_box_whole_px=_within_picture(bounds[k], camera) if areas[k] else box,
                mask_rle=pycocotools.mask.encode(np.asfortranarray(ids == target.label_id, np.uint8))["counts"],
                pose_world_object=target.pose_world_object.figures(),
                keypoints_px=_keypoints(target, faces_camera[k][0], camera),
                visible_px=visible_px,
                visible_fraction=fraction,
                truncation=float(truncations[k]),
                distance_m=float(np.linalg.norm(np.concatenate(faces_camera[k]).mean(axis=0))),
                ignore=visible_px < small_px or fraction < VISIBLE_FRACTION_MIN,
            )
        )
    return tuple(labels)


def _shows_front(target: Target, pose_camera_object: Pose3) -> bool:
    if target.front is None:
        return True
    (corner,) = pose_camera_object.transform(target.faces[0][:1])
    return float(corner @ (pose_camera_object.rotation @ target.front)) < 0.0


def _keypoints(target: Target, corners_camera: Array, camera: Camera) -> tuple[KeypointPx, ...]:
    if target.front is None or len(corners_camera) != 4:
        return NO_KEYPOINTS
    corners = camera.project(corners_camera)
    inside = ((corners >= 0) & (corners < (camera.width_px, camera.height_px))).all(axis=1).tolist()
    return tuple((u, v, 2) if seen else (0.0, 0.0, 0) for (u, v), seen in zip(corners.tolist(), inside, strict=True))


def tight_box(mask: NDArray[np.bool_]) -> BoxPx:
    """Return x0, y0, x1, y1 around the true pixels of a mask (h, w) that has some; borders, not centres."""
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    return float(x), float(y), float(x + width), float(y + height)


def _within_picture(box: Array, camera: Camera) -> BoxPx:
    """Return the box without what sticks out because the picture's border was undistorted and distorted again."""
    x0, y0, x1, y1 = box.tolist()
    return max(0.0, x0), max(0.0, y0), min(float(camera.width_px), x1), min(float(camera.height_px), y1)


def amodal_outlines(objects: Sequence[Sequence[Array]], camera: Camera) -> tuple[Geometries, Array]:
    """Return each object's outline in pixels (n,), clipped to the picture, as if nothing hid it, and the share of it
    that lies outside the picture (n,). An object is convex pieces (m, 3) in the camera's frame.

    The share is one of areas as a lens without distortion would show them: a lens model says nothing about what lies
    far outside the picture. All objects are treated in one go: calls cost more here than corners.
    """
    field, whole = _field(camera), _seen_flat(objects)
    inside = whole.copy()
    cut = ~shapely.contains_properly(field, whole)
    inside[cut] = shapely.intersection(whole[cut], field)
    areas = shapely.area(whole)
    truncations = 1.0 - np.divide(shapely.area(inside), areas, out=np.ones(len(areas)), where=areas > 0)
    if camera.k1 or camera.k2:
        inside = shapely.segmentize(inside, camera.width_px / camera.fx_px / EDGE_POINTS)
    outlines: Geometries = shapely.transform(inside, lambda plane: camera.project(_at_one_metre(plane)))
    return outlines, np.maximum(truncations, 0.0)


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


def _seen_flat(objects: Sequence[Sequence[Array]]) -> Geometries:
    """Return each object's outline (n,) in the plane z = 1 before the camera; empty if all of it lies behind."""
    hulls = np.full((len(objects), max(map(len, objects), default=0)), None, dtype=object)
    pieces = {(k, m): _before_near(face) for k, faces in enumerate(objects) for m, face in enumerate(faces)}
    pieces = {place: corners for place, corners in pieces.items() if len(corners) >= 3}
    if pieces:
        corners = np.concatenate(list(pieces.values()))
        lines = np.repeat(np.arange(len(pieces)), [len(piece) for piece in pieces.values()])
        places = tuple(np.array(list(pieces)).T)
        hulls[places] = shapely.convex_hull(shapely.linestrings(corners[:, :2] / corners[:, 2:], indices=lines))
    outlines: Geometries = shapely.union_all(hulls, axis=1)
    return outlines


def _before_near(corners: Array) -> Array:
    """Return corners (m, 3) of what of a convex piece lies before the near plane; m may be 0."""
    near = corners[:, 2] > NEAR_M
    if near.all():
        return corners
    before, behind = corners[near][:, None], corners[~near][None]
    share = (NEAR_M - before[..., 2]) / (behind[..., 2] - before[..., 2])
    cut = (before + share[..., None] * (behind - before)).reshape(-1, 3)
    return np.concatenate([corners[near], cut])
