"""The map's paint as edges: points along every border between paint and floor, each with its normal."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Pose2, wrap_array_rad
from adc_bench.world.course import Course

Array = NDArray[np.float64]

WIDEST_M = 0.3
SAME_M = 1e-6  # marks no farther apart than this touch


@dataclass(frozen=True, kw_only=True)
class EdgeMapParams:
    """How densely borders are sampled, and how far from corners, near which a picture shows no straight edge."""

    step_m: float = 0.05
    corner_margin_m: float = 0.016
    corner_rad: float = math.radians(15)


@dataclass(frozen=True, kw_only=True, eq=False)
class PaintEdges:
    """Points (n, 2) on borders of paint and unit normals (n, 2) from the paint to the floor, in the frame that its
    name tells; and how wide the paint is behind each, (n,) in metres, `WIDEST_M` at most.
    """

    points: Array
    normals: Array
    widths_m: Array

    def seen_from(self, pose: Pose2) -> "PaintEdges":
        """Return them in the frame of a pose."""
        inverse = pose.inverse()
        c, s = math.cos(inverse.yaw_rad), math.sin(inverse.yaw_rad)
        return PaintEdges(
            points=inverse.transform(self.points),
            normals=self.normals @ np.array([[c, s], [-s, c]]),
            widths_m=self.widths_m,
        )

    def of(self, chosen: NDArray[np.bool_]) -> "PaintEdges":
        """Return some of them."""
        return PaintEdges(points=self.points[chosen], normals=self.normals[chosen], widths_m=self.widths_m[chosen])


def paint_edges(course: Course, params: EdgeMapParams | None = None) -> PaintEdges:
    """Return the edges of all paint of a course, in the world; marks that touch are one."""
    p = params or EdgeMapParams()
    paint = shapely.union_all(course.paint, grid_size=SAME_M)
    rings = [ring for mark in shapely.get_parts(paint) for ring in _rings(mark)]
    rows = np.concatenate([_sampled(run, p) for ring in rings for run in _smooth_runs(ring, p.corner_rad)])
    points, normals = rows[:, :2], rows[:, 2:]
    return PaintEdges(points=points, normals=normals, widths_m=_widths(paint, points, normals))


def _rings(mark: shapely.Polygon) -> list[Array]:
    """Return the closed rings (k, 2) round a mark and round its holes, the paint on their left."""
    turned = shapely.geometry.polygon.orient(mark)
    return [_distinct(np.asarray(ring.coords)) for ring in (turned.exterior, *turned.interiors)]


def _distinct(ring: Array) -> Array:
    """Return a closed ring without repeated points."""
    apart = np.hypot(*np.diff(ring, axis=0).T) > 1e-9
    distinct: Array = ring[np.concatenate([[True], apart])]
    return distinct


def _smooth_runs(ring: Array, corner_rad: float) -> list[Array]:
    """Return the stretches (k, 2) of a closed ring from corner to corner; a ring without corners is one stretch."""
    sides = np.diff(ring, axis=0)
    heading = np.arctan2(sides[:, 1], sides[:, 0])
    turns = np.abs(wrap_array_rad(heading - np.roll(heading, 1)))
    corners = np.flatnonzero(turns > corner_rad)
    if not len(corners):
        return [ring]
    around = np.concatenate([ring[corners[0] : -1], ring[: corners[0] + 1]])
    cuts = [*(corners - corners[0]).tolist(), len(around) - 1]
    return [around[a : b + 1] for a, b in itertools.pairwise(cuts)]


def _sampled(run: Array, p: EdgeMapParams) -> Array:
    """Return rows (n, 4), point and normal, evenly spread along a stretch; none where it is shorter than its margins.

    The paint lies on the left of the stretch.
    """
    sides = np.diff(run, axis=0)
    lengths = np.hypot(*sides.T)
    knots = np.concatenate([[0.0], np.cumsum(lengths)])
    inner_m = knots[-1] - 2 * p.corner_margin_m
    if inner_m <= 0:
        return np.empty((0, 4))
    count = max(1, math.ceil(inner_m / p.step_m))
    s = p.corner_margin_m + (np.arange(count) + 0.5) / count * inner_m
    side = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, len(sides) - 1)
    along = sides[side] / lengths[side, None]
    points = run[side] + along * (s - knots[side])[:, None]
    return np.column_stack([points, along[:, 1], -along[:, 0]])


def _widths(paint: shapely.Geometry, points: Array, normals: Array) -> Array:
    """Return (n,): how far each edge's normal runs back through the paint."""
    back = np.stack([points - 1e-4 * normals, points - WIDEST_M * normals], axis=1)
    shapely.prepare(paint)
    inside = shapely.intersection(shapely.linestrings(back), paint)
    # Of the marks that the normal passes, the one at the edge comes first.
    return np.asarray(shapely.length(shapely.get_geometry(inside, 0)), dtype=np.float64)
