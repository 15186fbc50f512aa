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
class Blocker:
    """A box that casts a shadow: centre (3,), axes as columns (3, 3), half size (3,), bounding radius."""

    centre: Array
    rotation: Array
    half: Array
    radius_m: float

    @classmethod
    def of(cls, solid: Solid) -> "Blocker":
        """Return the solid as a blocker."""
        pose, half = solid.pose_world_solid(), np.array(solid.size_m) / 2
        half[:2] *= ROUND_SHARE[solid.shape]
        return cls(centre=pose.translation_m, rotation=pose.rotation, half=half, radius_m=float(np.linalg.norm(half)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Blockers:
    """Boxes in the light's way, their centres (n, 3) and bounding radii (n,) at hand."""

    each: Sequence[Blocker]
    centres: Array
    radii: Array

    @classmethod
    def of(cls, solids: Sequence[Solid]) -> "Blockers":
        """Return the solids as blockers."""
        each = [Blocker.of(solid) for solid in solids]
        centres = np.array([blocker.centre for blocker in each]).reshape(-1, 3)
        return cls(each=each, centres=centres, radii=np.array([blocker.radius_m for blocker in each]))


def shadowed(points: Array, towards: Array, blockers: Blockers) -> NDArray[np.bool_]:
    """Return for each of some rays (k, 3) that point nearly the same way, towards a far light, and each point (n, 3)
    whether a box stands in the ray's way (k, n): a slab test, culled by the boxes' bounding spheres.
    """
    hit = np.zeros((len(towards), len(points)), bool)
    if not blockers.each or not len(points):
        return hit
    axes, spread = _along(towards)
    u, v, w = np.einsum("ij,kj->ki", points, axes)
    centres, radii = np.einsum("ij,kj->ki", blockers.centres, axes), blockers.radii
    reach = radii + spread * np.maximum(centres[2] + radii - w.min(), 0)
    near_u = (centres[0] + reach > u.min()) & (centres[0] - reach < u.max())
    near_v = (centres[1] + reach > v.min()) & (centres[1] - reach < v.max())
    for k in np.flatnonzero(near_u & near_v & (centres[2] + radii > w.min())).tolist():
        cu, cv, cw = centres[:, k].tolist()
        ahead = cw - w
        within = radii[k] + spread * np.abs(ahead)
        near = ((u - cu) ** 2 + (v - cv) ** 2 < within * within) & (ahead > -radii[k])
        (some,) = near.nonzero()
        if len(some):
            blocker = blockers.each[k]
            local = np.einsum("ij,jk->ki", points[some] - blocker.centre, blocker.rotation)
            rays = np.einsum("ij,jk->ki", towards, blocker.rotation)
            hit[:, some] |= _rays_meet_box(local, np.where(np.abs(rays) < 1e-12, 1e-12, rays), blocker.half)
    return hit


def _along(rays: Array) -> tuple[Array, float]:
    """Return axes (3, 3), the third along the middle of rays (k, 3), and how far a ray strays from it per metre."""
    x, y, z = rays.mean(axis=0) / np.linalg.norm(rays.mean(axis=0))
    level = math.hypot(x, y)
    axes = np.array([[y / level, -x / level, 0.0], [-x * z / level, -y * z / level, level], [x, y, z]])
    sideways, ahead = rays @ axes[:2].T, rays @ axes[2]
    return axes, 1.01 * float((np.hypot(*sideways.T) / ahead).max())


def _rays_meet_box(origins: Array, rays: Array, half: Array) -> NDArray[np.bool_]:
    """Return whether rays (3, k) from points (3, n) meet the box of half size (3,) about the origin, ahead (k, n)."""
    middle, reach = origins[:, None] * (-1 / rays)[..., None], (half[:, None] / np.abs(rays))[..., None]
    enter, leave = middle - reach, middle + reach
    first = np.maximum(np.maximum(enter[0], enter[1]), enter[2])
    last = np.minimum(np.minimum(leave[0], leave[1]), leave[2])
    meets: NDArray[np.bool_] = last > np.maximum(first, 1e-6)
    return meets


@lru_cache(maxsize=3)
def _extremes(shape: Shape) -> Array:
    """Return points (n, 3) whose convex hull is the solid of half size one."""
    if shape == "box":
        return np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    angle = 2 * np.pi * np.arange(12) / 12
    ring = np.stack([np.cos(angle), np.sin(angle), np.full(12, -1.0)], axis=1)
    return np.vstack([ring, [[0.0, 0.0, 1.0]] if shape == "cone" else ring * (1, 1, -1)])


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
        each = [
            solid.pose_world_solid().transform(_extremes(solid.shape) * np.array(solid.size_m) / 2) for solid in solids
        ]
        points = np.concatenate(each) if each else np.empty((0, 3))
        if pose_world_body is not None:
            points = pose_world_body.transform(points)
        points[:, 2] = np.clip(points[:, 2], 0.0, TOP_M)
        return cls(solids=solids, points=points, starts=np.cumsum([0, *map(len, each)]).tolist())

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
    height = points[None, :, 2]
    far = lights[:, 3:] == 0
    # along the ray from the light through the point, down to the floor
    run = np.where(far, height / np.where(far, lights[:, 2:3], 1.0), height / (lights[:, 2:3] - height))
    level = lights[:, None, :2] - lights[:, None, 3:] * points[None, :, :2]
    shadows: Array = points[None, :, :2] - run[:, :, None] * level
    return shadows
