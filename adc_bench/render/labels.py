"""Labels from the picture of label ids, and what the whole object would look like from its known corners."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.world.frame import BoxPx, Label

Array = NDArray[np.float64]
NEAR_M = 0.02
# Below these an object is an ignore region: pixels at 320 x 240 (they grow with the picture), and visible share.
VISIBLE_PX_MIN = 40
VISIBLE_FRACTION_MIN = 0.2


@dataclass(frozen=True, kw_only=True, eq=False)
class Target:
    """An object that is labelled: its id in the picture, its category and its corners (4, 3) in the world."""

    label_id: int
    category_id: int
    instance: str
    corners_world: Array


def labels_of(
    ids: NDArray[np.uint8], targets: Sequence[Target], camera: Camera, pose_world_camera: Pose3
) -> tuple[Label, ...]:
    """Return the labels of every target with at least one visible pixel; `ids` (h, w) holds label ids."""
    counts = np.bincount(ids.ravel(), minlength=256)
    return tuple(
        _label(ids == target.label_id, int(counts[target.label_id]), target, camera, pose_world_camera)
        for target in targets
        if counts[target.label_id]
    )


def _label(mask: NDArray[np.bool_], visible_px: int, target: Target, camera: Camera, pose: Pose3) -> Label:
    corners_camera = pose.inverse().transform(target.corners_world)
    outline = projected_outline(corners_camera, camera)
    picture = shapely.box(0, 0, camera.width_px, camera.height_px)
    inside = outline.intersection(picture)
    amodal = inside.bounds if not inside.is_empty else tight_box(mask)
    fraction = min(1.0, visible_px / max(inside.area, 1.0))
    small = visible_px < VISIBLE_PX_MIN * (camera.width_px * camera.height_px) / (320 * 240)
    return Label(
        category_id=target.category_id,
        instance=target.instance,
        box_px=tight_box(mask),
        amodal_box_px=amodal,
        visible_px=visible_px,
        visible_fraction=fraction,
        truncation=max(0.0, 1.0 - inside.area / outline.area) if outline.area else 0.0,
        distance_m=float(np.linalg.norm(corners_camera.mean(axis=0))),
        ignore=small or fraction < VISIBLE_FRACTION_MIN,
    )


def tight_box(mask: NDArray[np.bool_]) -> BoxPx:
    """Return x0, y0, x1, y1 around the true pixels of a mask (h, w) that has some; borders, not centres."""
    columns, rows = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
    return float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1)


def projected_outline(corners_camera: Array, camera: Camera) -> shapely.Polygon:
    """Return the projection in pixels of a flat polygon (n, 3), the part behind the camera cut away."""
    kept = _clip_near(corners_camera)
    return shapely.Polygon(camera.project(kept)) if len(kept) >= 3 else shapely.Polygon()


def _clip_near(corners: Array) -> Array:
    kept: list[Array] = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if a[2] > NEAR_M:
            kept.append(a)
        if (a[2] > NEAR_M) != (b[2] > NEAR_M):
            kept.append(a + (b - a) * (NEAR_M * 1.0001 - a[2]) / (b[2] - a[2]))
    return np.array(kept).reshape(-1, 3)
