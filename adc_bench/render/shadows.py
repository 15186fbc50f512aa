"""Who stands in whose light: rays from points to far lights, and outlines of shadows on the floor."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

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
    """Return for each point (n, 3) whether a box stands between it and a far light (slab test, culled by spheres)."""
    hit = np.zeros(len(points), bool)
    if not blockers.each or not len(points):
        return hit
    x, y, z = towards
    across = np.array([[y, -x, 0.0], [-x * z, -y * z, x * x + y * y]]) / math.hypot(x, y)
    centres, radii = blockers.centres @ across.T, blockers.radii
    u, v = np.einsum("ij,j->i", points, across[0]), np.einsum("ij,j->i", points, across[1])
    near_u = (centres[:, 0] + radii > u.min()) & (centres[:, 0] - radii < u.max())
    near_v = (centres[:, 1] + radii > v.min()) & (centres[:, 1] - radii < v.max())
    for k in np.flatnonzero(near_u & near_v).tolist():
        near = np.flatnonzero((np.abs(u - centres[k, 0]) < radii[k]) & (np.abs(v - centres[k, 1]) < radii[k]))
        if len(near):
            blocker = blockers.each[k]
            local = np.einsum("ij,jk->ik", points[near] - blocker.centre, blocker.rotation)
            ray = towards @ blocker.rotation
            hit[near] |= _ray_meets_box(local, np.where(np.abs(ray) < 1e-12, 1e-12, ray), blocker.half)
    return hit


def _ray_meets_box(origins: Array, ray: Array, half: Array) -> NDArray[np.bool_]:
    """Return whether rays (3,) from points (n, 3) meet the box of half size (3,) about the origin, ahead of them."""
    middle, reach = -origins / ray, half / np.abs(ray)
    enter, leave = middle - reach, middle + reach
    first = np.maximum(np.maximum(enter[:, 0], enter[:, 1]), enter[:, 2])
    last = np.minimum(np.minimum(leave[:, 0], leave[:, 1]), leave[:, 2])
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


def outline_points(solid: Solid, pose_world_body: Pose3 | None = None) -> Array:
    """Return points (n, 3) in the world whose convex hull is the solid, none below the floor or near the lamps."""
    pose = solid.pose_world_solid()
    if pose_world_body is not None:
        pose = pose_world_body @ pose
    points: Array = pose.transform(_extremes(solid.shape) * np.array(solid.size_m) / 2)
    points[:, 2] = np.clip(points[:, 2], 0.0, TOP_M)
    return points


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
