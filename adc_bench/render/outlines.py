"""What whole objects would look like with nothing before them, from their known shapes."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Camera
from adc_bench.world.frame import BoxPx

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Geometries = NDArray[np.object_]
NEAR_M = 0.02
# A distorted edge is drawn through so many points a picture width; its error is then below 0.1 px.
EDGE_POINTS = 32
AROUND = 1.0  # pictures' widths and heights beyond each border within which a whole object's box is given
LENS_RADIUS_MAX, LENS_STEPS = 20.0, 20_001  # of the table by which a lens is undone outside the picture


@dataclass(frozen=True, kw_only=True, eq=False)
class Pieces:
    """Objects in the camera's frame, each the union of convex pieces.

    Attributes:
        corners: (m, 3) of all pieces, one after the other.
        sizes: (p,) how many corners each piece has.
        owners: (p,) which object each piece belongs to, rising.
        count: how many objects there are.
    """

    corners: Array
    sizes: Integers
    owners: Integers
    count: int

    @classmethod
    def of(cls, objects: Sequence[Sequence[Array]]) -> "Pieces":
        """Return the pieces of objects given as lists of corners (m, 3)."""
        pieces = [piece for pieces in objects for piece in pieces]
        return cls(
            corners=np.concatenate([np.empty((0, 3)), *pieces]),
            sizes=np.array([len(piece) for piece in pieces], np.int64),
            owners=np.repeat(np.arange(len(objects)), [len(pieces) for pieces in objects]),
            count=len(objects),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Outlines:
    """Objects' outlines in a picture, as if nothing hid them.

    Attributes:
        shapes_px: (n,) polygons of what lies in the picture, empty where nothing does.
        areas_px: of the shapes; 0 too for a board seen along its plane.
        truncations: shares of the whole areas outside the picture.
        boxes_px: around the shapes; None for those without an area.
        boxes_whole_px: around what lies in the picture or up to `AROUND` pictures beside it; None likewise.
    """

    shapes_px: Geometries
    areas_px: list[float]
    truncations: list[float]
    boxes_px: list[BoxPx | None]
    boxes_whole_px: list[BoxPx | None]


def outlines_of(pieces: Pieces, camera: Camera) -> Outlines:
    """Return the outlines of objects (n,) in the camera's frame.

    The truncation is a share of areas as a lens without distortion would show them: a lens model says nothing about
    what lies far outside the picture. The box of the whole object takes the model at its word there, or as far as it
    rises. All objects are treated in one go: calls cost more here than corners.
    """
    flat = _seen_flat(pieces)
    inside, cut = _cut(flat, _field(camera, 0.0))
    beyond, _ = _cut(flat[cut], _field(camera, AROUND))
    areas = shapely.area(flat)
    shares = np.divide(shapely.area(inside), areas, out=np.ones(len(areas)), where=areas > 0)
    drawn = _behind_lens(np.concatenate([inside, beyond]), camera)
    bounds, count = shapely.bounds(drawn), len(inside)
    whole = bounds[:count].copy()
    whole[cut] = bounds[count:]
    areas_px = shapely.area(drawn[:count])
    return Outlines(
        shapes_px=drawn[:count],
        areas_px=areas_px.tolist(),
        truncations=np.maximum(1.0 - shares, 0.0).tolist(),
        boxes_px=_boxes(bounds[:count], areas_px, camera, 0.0),
        boxes_whole_px=_boxes(whole, areas_px, camera, AROUND),
    )


def _boxes(bounds_px: Array, areas_px: Array, camera: Camera, around: float) -> list[BoxPx | None]:
    """Return boxes without what sticks out because a border was undistorted and distorted again."""
    size = np.array([camera.width_px, camera.height_px, camera.width_px, camera.height_px], dtype=np.float64)
    within = np.clip(bounds_px, 0.0 - around * size, (1.0 + around) * size).tolist()
    return [(x0, y0, x1, y1) if area else None for (x0, y0, x1, y1), area in zip(within, areas_px, strict=True)]


def _cut(flat: Geometries, field: shapely.Polygon) -> tuple[Geometries, NDArray[np.bool_]]:
    """Return what of each outline lies in a field, and which of them stick out."""
    cut = ~shapely.contains_properly(field, flat)
    inside = flat.copy()
    inside[cut] = shapely.intersection(flat[cut], field)
    return inside, cut


def _behind_lens(flat: Geometries, camera: Camera) -> Geometries:
    """Return in pixels what lies in the plane z = 1 before the camera."""
    if camera.k1 or camera.k2:
        flat = shapely.segmentize(flat, camera.width_px / camera.fx_px / EDGE_POINTS)
    pixels: Geometries = shapely.transform(
        flat, lambda plane: camera.project(np.column_stack([plane, np.ones(len(plane))]))
    )
    return pixels


@lru_cache(maxsize=32)
def _field(camera: Camera, around: float) -> shapely.Polygon:
    """Return, in the plane z = 1 before the camera, the border of the picture widened by this share of its size.

    Where the lens model does not reach so far, because it folds before, the border is where it folds.
    """
    u_px, v_px = around * camera.width_px, around * camera.height_px
    frame = shapely.box(-u_px, -v_px, camera.width_px + u_px, camera.height_px + v_px)
    border = shapely.get_coordinates(shapely.segmentize(frame, camera.width_px / EDGE_POINTS))
    distorted = (border - (camera.cx_px, camera.cy_px)) / (camera.fx_px, camera.fy_px)
    wanted = np.hypot(distorted[:, 0], distorted[:, 1])
    field = shapely.Polygon(distorted * (_undistorted_radius(wanted, camera) / wanted)[:, None])
    shapely.prepare(field)
    return field


def _undistorted_radius(wanted: Array, camera: Camera) -> Array:
    """Return the radii (n,) at z = 1 that the lens shows at the wanted ones; the last before a fold at most."""
    if not (camera.k1 or camera.k2):
        return wanted
    radius = np.linspace(0.0, LENS_RADIUS_MAX, LENS_STEPS)
    pixels = camera.project(np.column_stack([radius, np.zeros(LENS_STEPS), np.ones(LENS_STEPS)]))
    shown = (pixels[:, 0] - camera.cx_px) / camera.fx_px
    rises = ~np.isnan(shown)
    found: Array = np.interp(wanted, shown[rises], radius[rises])
    return found


def _seen_flat(pieces: Pieces) -> Geometries:
    """Return each object's outline (n,) in the plane z = 1 before the camera; empty if all of it lies behind."""
    corners, sizes, owners = pieces.corners, pieces.sizes, pieces.owners
    if not (corners[:, 2] > NEAR_M).all():
        corners, sizes, owners = _before_near(pieces)
    outlines: Geometries = np.full(pieces.count, shapely.Polygon(), dtype=object)
    if len(sizes):
        lines = shapely.linestrings(corners[:, :2] / corners[:, 2:], indices=np.repeat(np.arange(len(sizes)), sizes))
        hulls, count = shapely.convex_hull(lines), np.bincount(owners, minlength=pieces.count)
        first = np.cumsum(count) - count
        outlines[count > 0] = hulls[first[count > 0]]
        for more in range(1, int(count.max())):
            several = count > more
            outlines[several] = shapely.union(outlines[several], hulls[first[several] + more])
    return outlines


def _before_near(pieces: Pieces) -> tuple[Array, Integers, Integers]:
    """Return corners, sizes and owners, as `Pieces` has them, of what lies before the near plane."""
    cut = [_cut_piece(piece) for piece in np.split(pieces.corners, np.cumsum(pieces.sizes)[:-1])]
    kept = [k for k, corners in enumerate(cut) if len(corners) >= 3]
    corners = np.concatenate([np.empty((0, 3)), *(cut[k] for k in kept)])
    return corners, np.array([len(cut[k]) for k in kept], np.int64), pieces.owners[kept]


def _cut_piece(corners: Array) -> Array:
    near = corners[:, 2] > NEAR_M
    if near.all():
        return corners
    before, behind = corners[near][:, None], corners[~near][None]
    share = (NEAR_M - before[..., 2]) / (behind[..., 2] - before[..., 2])
    cut = (before + share[..., None] * (behind - before)).reshape(-1, 3)
    return np.concatenate([corners[near], cut])
