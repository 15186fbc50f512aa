"""The semantic mask of a picture: things from the label picture, the floor from where each pixel's ray meets it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render.other_ids import OtherId
from adc_bench.render.targets import Target
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.semantics import SemanticClass, category_class, floor_regions

Classes = NDArray[np.uint8]
TEXEL_M = 0.0025  # what a pixel of the nearest floor in a 320 x 240 picture covers
SHIFT = 6  # binary places of OpenCV's coordinates


@dataclass(frozen=True, kw_only=True, eq=False)
class FloorMap:
    """The floor's classes (h, w) where there is anything but bare floor; row 0 is the largest y."""

    classes: Classes
    left_m: float
    top_m: float

    @classmethod
    def of(cls, course: Course) -> "FloorMap":
        """Draw the course's regions."""
        regions = floor_regions(course)
        x0, y0, x1, y1 = shapely.total_bounds([polygon for _, polygons in regions for polygon in polygons])
        shape = int(np.ceil((y1 - y0) / TEXEL_M)), int(np.ceil((x1 - x0) / TEXEL_M))
        classes = np.full(shape, SemanticClass.FLOOR, np.uint8)
        for known, polygons in regions:
            for polygon in polygons:
                _fill(classes, polygon, (float(x0), float(y1)), int(known))
        classes.setflags(write=False)
        return cls(classes=classes, left_m=float(x0), top_m=float(y1))

    def at(self, points_world: ArrayLike) -> Classes:
        """Return the classes (n,) at floor points, x and y (2, n); points that are nan lie on bare floor."""
        x, y = np.asarray(points_world)
        column, row = np.floor((x - self.left_m) / TEXEL_M), np.floor((self.top_m - y) / TEXEL_M)
        height, width = self.classes.shape
        inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
        found = np.full(len(x), SemanticClass.FLOOR, np.uint8)
        found[inside] = self.classes[row[inside].astype(np.intp), column[inside].astype(np.intp)]
        return found


def _fill(classes: Classes, polygon: shapely.Polygon, corner_m: tuple[float, float], known: int) -> None:
    shrunk = polygon.buffer(-TEXEL_M / 2, join_style="mitre")  # cv2 also fills the pixels that an outline crosses
    rings = [ring for part in shapely.get_parts(shrunk) for ring in (part.exterior, *part.interiors)]
    flat = [(shapely.get_coordinates(ring) - corner_m) / (TEXEL_M, -TEXEL_M) - 0.5 for ring in rings]
    cv2.fillPoly(classes, [np.round(ring * 2**SHIFT).astype(np.int32) for ring in flat], known, cv2.LINE_8, SHIFT)


@lru_cache(maxsize=2)
def floor_map(spec: CourseSpec) -> FloorMap:
    """Return a course's map."""
    return FloorMap.of(Course(spec=spec))


def semantic_mask(
    ids: NDArray[np.uint8], targets: Sequence[Target], camera: Camera, pose_world_camera: Pose3, spec: CourseSpec
) -> Classes:
    """Return each pixel's class (h, w), see `world/semantics.py`, from the label ids (h, w) of the delivered picture.

    A pixel's class is that of its centre: what the label picture has there, and on the floor what the course has where
    the ray through it, the lens undone, meets z = 0.
    """
    class_of_id = np.full(256, SemanticClass.FLOOR, np.uint8)
    for other in OtherId:
        class_of_id[other] = SemanticClass[other.name]
    for target in targets:
        class_of_id[target.label_id] = category_class(target.category_id)
    classes = np.asarray(cv2.LUT(ids, class_of_id), np.uint8)
    floor = ids == OtherId.FLOOR
    classes[floor] = floor_map(spec).at(_floor_points(_plane(camera)[:, floor], pose_world_camera))
    return classes


def _floor_points(plane: NDArray[np.float32], pose_world_camera: Pose3) -> NDArray[np.float32]:
    """Return where the rays through points (2, n) of the plane z = 1 before the camera meet the floor, (2, n); nan
    where they do not.
    """
    right, down, ahead = pose_world_camera.rotation.T.astype(np.float32)  # a product of matrices costs threads
    along, across, up = (right[k] * plane[0] + down[k] * plane[1] + ahead[k] for k in range(3))
    x, y, z = pose_world_camera.translation_m.astype(np.float32)
    reach = np.where(up < 0, -z / np.minimum(up, np.float32(-1e-9)), np.float32(np.nan))
    return np.stack([x + reach * along, y + reach * across])


@lru_cache(maxsize=8)
def _plane(camera: Camera) -> NDArray[np.float32]:
    """Return where the rays through the pixels' centres meet the plane z = 1 before the camera, (2, h, w)."""
    v, u = np.mgrid[: camera.height_px, : camera.width_px] + 0.5
    rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]))
    plane = np.ascontiguousarray(rays[:, :2].T.reshape(2, *u.shape), np.float32)
    plane.setflags(write=False)
    return plane
