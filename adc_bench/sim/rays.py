"""Where rays first meet solids: boxes, cylinders and cones at any attitude, many rays at once.

A solid is mapped to one that reaches from -1 to 1 along each axis: a cube, a round rod, a cone with its tip up. The map
is affine, so that lengths along a ray stay what they were; every shape is convex, so that a ray is inside it once.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.world.solids import Body, Solid

Array = NDArray[np.float64]

_FLAT = 1e-12  # a smaller leading coefficient of the quadratic is taken for this


class Obstacles:
    """Everything that a ray can meet: the floor z = 0, the solids, and the bodies where they were last moved to."""

    def __init__(self, solids: Sequence[Solid], bodies: Sequence[Body]) -> None:
        parts = [*solids, *(part for body in bodies for part in body.parts)]
        places = [part.pose_world_solid() for part in parts]
        half_m = np.array([part.size_m for part in parts]).reshape(-1, 3) / 2
        self._own_centre_m = np.array([place.translation_m for place in places]).reshape(-1, 3)
        self._own_unit = np.array([place.rotation.T for place in places]).reshape(-1, 3, 3) / half_m[:, :, None]
        self._centre_m, self._unit = self._own_centre_m.copy(), self._own_unit.copy()
        self._radius_m = np.linalg.norm(half_m, axis=1)
        self._is_box = np.array([part.shape == "box" for part in parts], dtype=bool)
        self._narrows = np.array([0.5 if part.shape == "cone" else 0.0 for part in parts])
        self._parts_of: dict[str, slice] = {}
        self._poses: dict[str, Pose3] = {}
        first = len(solids)
        for body in bodies:
            self._parts_of[body.name] = slice(first, first + len(body.parts))
            self._move(body.name, body.pose.to_pose3())
            first += len(body.parts)

    def follow(self, poses: Mapping[str, Pose3]) -> None:
        """Move the bodies, by name; one whose pose is the same record as before has not moved."""
        for name, pose in poses.items():
            if pose is not self._poses[name]:
                self._move(name, pose)

    def _move(self, name: str, pose: Pose3) -> None:
        parts = self._parts_of[name]
        self._centre_m[parts] = self._own_centre_m[parts] @ pose.rotation.T + pose.translation_m
        self._unit[parts] = self._own_unit[parts] @ pose.rotation.T
        self._poses[name] = pose

    def fan_distances_m(self, origin_m: Array, directions: Array, normal: Array, reach_m: float) -> Array:
        """Return how far (n,) rays of unit directions (n, 3) go, all square to `normal`; inf for nothing in reach."""
        apart_m = self._centre_m - origin_m
        near = (np.abs(apart_m @ normal) <= self._radius_m) & (
            np.einsum("mk,mk->m", apart_m, apart_m) <= (reach_m + self._radius_m) ** 2
        )
        distances_m = _to_floor(origin_m, directions)
        for chosen, inside in ((near & self._is_box, _inside_cube), (near & ~self._is_box, _inside_round)):
            if chosen.any():
                unit = self._unit[chosen]
                start = -np.einsum("mij,mj->mi", unit, apart_m[chosen])
                enter, leave = inside(start[:, :, None], unit @ directions.T, self._narrows[chosen, None])
                enter = np.maximum(enter, 0.0)
                distances_m = np.minimum(distances_m, np.where(enter <= leave, enter, np.inf).min(axis=0))
        return np.where(distances_m <= reach_m, distances_m, np.inf)


def _to_floor(origin_m: Array, directions: Array) -> Array:
    down = -directions[:, 2]
    return np.where(down > 0, origin_m[2] / np.where(down > 0, down, 1.0), np.inf)


def between_walls(start: Array, steps: Array) -> tuple[Array, Array]:
    """Return where (m, n) lines, from `start` (m, k, 1) by t `steps` (m, k, n), enter and leave |x_k| <= 1."""
    with np.errstate(divide="ignore", invalid="ignore"):  # along a wall: an infinite or, on the wall, no number
        first, second = (-1.0 - start) / steps, (1.0 - start) / steps
    enter: Array = np.fmax.reduce(np.fmin(first, second), axis=1)
    leave: Array = np.fmin.reduce(np.fmax(first, second), axis=1)
    return enter, leave


def _inside_cube(start: Array, steps: Array, narrows: Array) -> tuple[Array, Array]:
    return between_walls(start, steps)


def _inside_round(start: Array, steps: Array, narrows: Array) -> tuple[Array, Array]:
    """Return where lines are inside x^2 + y^2 <= r(z)^2, |z| <= 1, with r = 1 in a rod, r = (1 - z) / 2 in a cone.

    `narrows` (m, 1) is -dr/dz. The lines are inside where a t^2 + 2 b t + c <= 0; a < 0 on lines steeper than the cone,
    which leave its lower half for good or come into it for good.
    """
    enter, leave = between_walls(start[:, 2:], steps[:, 2:])
    x, y, z = start[:, 0], start[:, 1], start[:, 2]
    dx, dy, dz = steps[:, 0], steps[:, 1], steps[:, 2]
    radius = 1.0 - narrows - narrows * z
    a = dx**2 + dy**2 - (narrows * dz) ** 2
    a = np.where(np.abs(a) < _FLAT, _FLAT, a)
    b = x * dx + y * dy + narrows * dz * radius
    c = x**2 + y**2 - radius**2
    root = np.sqrt(np.maximum(b**2 - a * c, 0.0))
    steep = a < 0
    low, high = (-b - np.where(steep, -root, root)) / a, (-b + np.where(steep, -root, root)) / a
    enter = np.fmax(enter, np.where(steep, np.where(dz > 0, -np.inf, high), low))
    leave = np.fmin(leave, np.where(steep, np.where(dz > 0, low, np.inf), high))
    missed = b**2 < a * c
    return np.where(missed, np.inf, enter), np.where(missed, -np.inf, leave)
