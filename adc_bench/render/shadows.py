"""Who stands in whose light: rays from points to far lights, and outlines of shadows on the floor."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.world.solids import Shape, Solid

Array = NDArray[np.float64]
# A round thing stands in a ray's way as the box of its own cross section's area.
ROUND_SHARE = {"box": 1.0, "cylinder": 0.89, "cone": 0.6}


TOP_M = 3.0  # what flies higher throws its shadow from here


@dataclass(frozen=True, kw_only=True, eq=False)
class Blockers:
    """Boxes that cast shadows: centres (n, 3), axes as columns (n, 3, 3), half sizes (n, 3), bounding radii (n,)."""

    centres: Array
    rotations: Array
    halves: Array
    radii: Array

    @classmethod
    def of(cls, solids: Sequence[Solid]) -> "Blockers":
        """Return the solids as blockers."""
        shares = np.array([(ROUND_SHARE[solid.shape],) * 2 + (1.0,) for solid in solids]).reshape(-1, 3)
        halves = np.array([solid.size_m for solid in solids]).reshape(-1, 3) / 2 * shares
        return cls(
            centres=np.array([solid.centre_m for solid in solids]).reshape(-1, 3),
            rotations=np.array([solid.pose_world_solid().rotation for solid in solids]).reshape(-1, 3, 3),
            halves=halves,
            radii=np.sqrt((halves**2).sum(axis=1)),
        )


def shadowed(points: Array, towards: Array, blockers: Blockers) -> NDArray[np.bool_]:
    """Return for each of some rays (k, 3) that point nearly the same way, towards a far light, and each point (n, 3)
    whether a box stands in the ray's way (k, n): a slab test of the pairs of box and point that are near each other.
    """
    hit = np.zeros((len(towards), len(points)), bool)
    if len(blockers.radii) and len(points):
        box, point = _near_pairs(points, towards, blockers)
        pair, ray = _rays_meet_boxes(points[point], towards, blockers, box).nonzero()
        hit[ray, point[pair]] = True
    return hit


def _near_pairs(points: Array, towards: Array, blockers: Blockers) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of box and point (m,), (m,) where the box's bounding sphere is near a ray of the point's."""
    axes, spread = _along(towards)
    seen = np.einsum("ij,kj->ki", points, axes).astype(np.float32)
    by_u = np.argsort(seen[0])
    u, v, w = seen[:, by_u]
    centres, radii = (
        np.einsum("ij,kj->ki", blockers.centres, axes).astype(np.float32),
        blockers.radii.astype(np.float32),
    )
    reach = radii + np.float32(spread) * np.maximum(centres[2] + radii - w.min(), 0)
    first = np.searchsorted(u, centres[0] - reach)
    count = np.searchsorted(u, centres[0] + reach) - first
    count[(centres[1] + reach < v.min()) | (centres[1] - reach > v.max()) | (centres[2] + radii < w.min())] = 0
    box = np.repeat(np.arange(len(radii)), count)
    place = np.arange(len(box)) + np.repeat(first - (np.cumsum(count) - count), count)
    ahead = centres[2][box] - w[place]
    within = radii[box] + np.float32(spread) * np.abs(ahead)
    off = (u[place] - centres[0][box]) ** 2 + (v[place] - centres[1][box]) ** 2
    near = np.flatnonzero((off < within * within) & (ahead > -radii[box]))
    return box[near], by_u[place[near]]


def _along(rays: Array) -> tuple[Array, float]:
    """Return axes (3, 3), the third along the middle of rays (k, 3), and how far a ray strays from it per metre."""
    x, y, z = rays.mean(axis=0) / np.linalg.norm(rays.mean(axis=0))
    level = math.hypot(x, y)
    axes = np.array([[y / level, -x / level, 0.0], [-x * z / level, -y * z / level, level], [x, y, z]])
    sideways, ahead = rays @ axes[:2].T, rays @ axes[2]
    return axes, 1.01 * float((np.hypot(*sideways.T) / ahead).max())


def _rays_meet_boxes(points: Array, towards: Array, blockers: Blockers, box: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Return whether rays (k, 3) from points (m, 3) meet each point's box (m,), ahead (m, k)."""
    rays = np.einsum("nij,ki->nkj", blockers.rotations, towards)
    slow = (-1 / np.where(np.abs(rays) < 1e-12, 1e-12, rays)).astype(np.float32)
    reach = blockers.halves[:, None].astype(np.float32) * np.abs(slow)
    away = (points - blockers.centres[box]).astype(np.float32)
    local = np.einsum("mi,mij->mj", away, blockers.rotations.astype(np.float32)[box])
    first = np.full((len(box), len(towards)), np.float32(1e-6))
    last = np.full_like(first, np.inf)
    for axis in range(3):
        middle, half = local[:, axis, None] * slow[box, :, axis], reach[box, :, axis]
        np.maximum(first, middle - half, out=first)
        np.minimum(last, middle + half, out=last)
    meets: NDArray[np.bool_] = last > first
    return meets


@lru_cache(maxsize=3)
def _extremes(shape: Shape) -> Array:
    """Return points (n, 3) whose convex hull is the solid of half size one."""
    if shape == "box":
        return np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    angle = 2 * np.pi * np.arange(12) / 12
    ring = np.stack([np.cos(angle), np.sin(angle), np.full(12, -1.0)], axis=1)
    return np.vstack([ring, [[0.0, 0.0, 1.0]] if shape == "cone" else ring * (1, 1, -1)])


@lru_cache(maxsize=64)
def _extremes_of(solids: tuple[Solid, ...]) -> tuple[Array, Sequence[int]]:
    """Return points (n, 3) around solids in their common frame, where each one's begin, and n."""
    each = [solid.pose_world_solid().transform(_extremes(solid.shape) * np.array(solid.size_m) / 2) for solid in solids]
    points = np.concatenate(each) if each else np.empty((0, 3))
    points.setflags(write=False)
    return points, tuple(np.cumsum([0, *map(len, each)]).tolist())


@dataclass(frozen=True, kw_only=True, eq=False)
class Outlines:
    """Solids as points.

    Attributes:
        points: (n, 3) in the world, none below the floor or near the lamps, one solid after the other; the convex hull
            of a solid's points is the solid.
        starts: where each solid's points begin, and n.
    """

    solids: Sequence[Solid]
    points: Array
    starts: Sequence[int]

    @classmethod
    def of(cls, solids: Sequence[Solid], pose_world_body: Pose3 | None = None) -> "Outlines":
        """Return the outlines of solids whose frame is the world or, if its pose is given, a body's."""
        points, starts = _extremes_of(tuple(solids))
        if pose_world_body is not None:
            points = pose_world_body.transform(points)
        clipped = points.copy()
        clipped[:, 2] = np.clip(points[:, 2], 0.0, TOP_M)
        return cls(solids=solids, points=clipped, starts=starts)

    @property
    def heights_m(self) -> list[tuple[float, float]]:
        """Each solid's bottom and top."""
        z = self.points[:, 2]
        bottoms, tops = np.minimum.reduceat(z, self.starts[:-1]), np.maximum.reduceat(z, self.starts[:-1])
        return list(zip(bottoms.tolist(), tops.tolist(), strict=True))

    def each(self, of_points: NDArray[Any]) -> list[NDArray[Any]]:
        """Return an array (n, ...) cut into one of each solid."""
        return [of_points[start:end] for start, end in itertools.pairwise(self.starts)]

    def lowest(self, of_points: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the least of an array (k, n, 2) over each solid's points (k, solids, 2)."""
        return np.minimum.reduceat(of_points, self.starts[:-1], axis=1)

    def highest(self, of_points: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the greatest of an array (k, n, 2) over each solid's points (k, solids, 2)."""
        return np.maximum.reduceat(of_points, self.starts[:-1], axis=1)

    def shadows(self, lights: Array) -> Array:
        """Return the points' shadows on the floor (k, n, 2) in each of some lights, see `shadow_points`."""
        return shadow_points(self.points, lights)


def shadow_points(points: Array, lights: Array) -> Array:
    """Return the shadows of points on the floor (k, n, 2), one set in each light.

    Args:
        points: (n, 3), not below the floor.
        lights: (k, 4) homogeneous: a lamp's place with a 1, or the direction towards a far light with a 0.
    """
    height, near = points[None, :, 2], lights[:, 3:]
    # along the ray from the light through the point, down to the floor
    run = height / (lights[:, 2:3] - near * height)
    level = lights[:, None, :2] - near[:, :, None] * points[None, :, :2]
    level *= run[:, :, None]
    shadows: Array = np.subtract(points[None, :, :2], level, out=level)
    return shadows
