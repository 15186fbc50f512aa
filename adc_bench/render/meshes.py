"""Triangles with texture coordinates, and the patches that solids are covered with.

A patch is a piece of surface with a square texture of its own; its light is a small picture over that square.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.render.surfaces import Rectangle, box_faces
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]
UvBox = tuple[float, float, float, float]
SIDES = 16  # of a round thing
TEXELS_MAX = 120  # along a patch


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """Triangles with texture coordinates: vertices (n, 3), normals (n, 3), uvs (n, 2), triangles (m, 3)."""

    vertices: NDArray[np.float32]
    normals: NDArray[np.float32]
    uvs: NDArray[np.float32]
    triangles: NDArray[np.uint32]

    def within(self, box: UvBox) -> "Mesh":
        """Return the mesh with its texture coordinates moved into a part (u0, v0, u1, v1) of a larger texture."""
        u0, v0, u1, v1 = box
        uvs = np.array([u0, v0]) + self.uvs * np.array([u1 - u0, v1 - v0])
        return replace(self, uvs=uvs.astype(np.float32))

    def moved(self, pose: Pose3) -> "Mesh":
        """Return the mesh in the outer frame."""
        vertices = self.vertices.astype(np.float64) @ pose.rotation.T + pose.translation_m
        normals = self.normals.astype(np.float64) @ pose.rotation.T
        return replace(self, vertices=vertices.astype(np.float32), normals=normals.astype(np.float32))


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh of several."""
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return Mesh(
        vertices=np.concatenate([mesh.vertices for mesh in meshes]),
        normals=np.concatenate([mesh.normals for mesh in meshes]),
        uvs=np.concatenate([mesh.uvs for mesh in meshes]),
        triangles=np.concatenate(
            [mesh.triangles + np.uint32(start) for mesh, start in zip(meshes, first, strict=True)]
        ),
    )


def rectangles_mesh(rectangles: Sequence[Rectangle], uv_boxes: Sequence[UvBox]) -> Mesh:
    """Return one mesh of rectangles, each with its part (u0, v0, u1, v1) of a shared texture."""
    uvs = [[(u0, v0), (u1, v0), (u1, v1), (u0, v1)] for u0, v0, u1, v1 in uv_boxes]
    quads = np.arange(len(rectangles))[:, None, None] * 4 + np.array([[0, 3, 2], [0, 2, 1]])
    return Mesh(
        vertices=np.concatenate([r.corners() for r in rectangles]).astype(np.float32),
        normals=np.repeat([r.normal for r in rectangles], 4, axis=0).astype(np.float32),
        uvs=np.array(uvs, np.float32).reshape(-1, 2),
        triangles=quads.reshape(-1, 3).astype(np.uint32),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """Where a light picture is sampled: points (n, 3), unit normals (n, 3), and each texel's sample (h, w)."""

    points: Array
    normals: Array
    index: NDArray[np.int32]

    def moved(self, pose: Pose3) -> "Samples":
        """Return the samples in the outer frame."""
        points = np.einsum("ij,kj->ik", self.points, pose.rotation) + pose.translation_m
        return replace(self, points=points, normals=np.einsum("ij,kj->ik", self.normals, pose.rotation))

    def picture(self, rgb: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the picture (h, w, 4) of the samples' light (n, 3)."""
        return np.asarray(np.insert(rgb, 3, 0, axis=1)[self.index], np.float32)


@dataclass(frozen=True, kw_only=True, eq=False)
class Patch:
    """A piece of a solid's surface: its mesh with uvs over the unit square, its size in metres (down, across), and
    the points (n, 3) and unit normals (n, 3) at texture coordinates (n,), (n,).
    """

    mesh: Mesh
    size_m: tuple[float, float]
    at: Callable[[Array, Array], tuple[Array, Array]]

    def texels(self, texel_m: float) -> tuple[int, int]:
        """Return the light picture's shape (h, w) at about this texel size."""
        h, w = (min(max(math.ceil(size / texel_m), 1), TEXELS_MAX) for size in self.size_m)
        return h, w

    def samples(self, texel_m: float) -> "Samples":
        """Return where the light picture of this patch alone is sampled."""
        shape = self.texels(texel_m)
        points, normals = self.texel_centres(shape)
        index = np.arange(len(points), dtype=np.int32).reshape(shape)
        return Samples(points=points, normals=normals, index=index)

    def texel_centres(self, shape: tuple[int, int]) -> tuple[Array, Array]:
        """Return points (h w, 3) and normals (h w, 3) at the texels' centres."""
        height, width = shape
        u, v = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
        return self.at(np.tile(u, height), np.repeat(v, width))


def patches(solid: Solid) -> Iterator[Patch]:
    """Yield the patches of a solid of any shape, where its pose puts it."""
    if solid.shape == "box":
        for face in box_faces(solid):
            yield flat_patch(face)
        return
    pose, tip = solid.pose_world_solid(), 0.0 if solid.shape == "cone" else 1.0
    yield _side(solid, pose, tip)
    for z_sign in (-1.0,) if solid.shape == "cone" else (-1.0, 1.0):
        yield _disc(solid, pose, z_sign)


def flat_patch(face: Rectangle) -> Patch:
    """Return a rectangle as a patch."""
    size = (float(np.linalg.norm(face.down)), float(np.linalg.norm(face.right)))
    normal = face.normal
    return Patch(
        mesh=rectangles_mesh([face], [(0, 0, 1, 1)]),
        size_m=size,
        at=lambda u, v: (face.at(u, v), np.broadcast_to(normal, (len(u), 3))),
    )


def _side(solid: Solid, pose: Pose3, tip: float) -> Patch:
    """Return the side of a cylinder (tip 1) or cone (tip 0): u runs round, v from the top down."""
    rx, ry, half = (s / 2 for s in solid.size_m)
    slope = (1 - tip) * (rx + ry) / 2 / (2 * half)

    def at(u: Array, v: Array) -> tuple[Array, Array]:
        c, s, reach = np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), tip + (1 - tip) * v
        local = np.stack([rx * reach * c, ry * reach * s, half * (1 - 2 * v)], axis=1)
        normals = np.stack([c * ry, s * rx, np.full(len(u), slope * (rx + ry) / 2)], axis=1)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return local @ pose.rotation.T + pose.translation_m, normals @ pose.rotation.T

    round_u = np.arange(SIDES + 1) / SIDES
    uvs = np.concatenate([np.stack([round_u, np.full(SIDES + 1, v)], axis=1) for v in (0.0, 1.0)])
    points, normals = at(uvs[:, 0], uvs[:, 1])
    k = np.arange(SIDES)[:, None]
    low = k + SIDES + 1
    triangles = np.concatenate([np.hstack([k, low, low + 1]), np.hstack([k, low + 1, k + 1])])
    mesh = Mesh(
        vertices=points.astype(np.float32),
        normals=normals.astype(np.float32),
        uvs=uvs.astype(np.float32),
        triangles=triangles.astype(np.uint32),
    )
    return Patch(mesh=mesh, size_m=(2 * half, math.pi * (rx + ry)), at=at)


def _disc(solid: Solid, pose: Pose3, z_sign: float) -> Patch:
    """Return the top or bottom of a round solid, its texture the square around it."""
    rx, ry, half = (s / 2 for s in solid.size_m)
    normal = pose.rotation @ np.array([0.0, 0.0, z_sign])

    def at(u: Array, v: Array) -> tuple[Array, Array]:
        local = np.stack([rx * (2 * u - 1), z_sign * ry * (1 - 2 * v), np.full(len(u), z_sign * half)], axis=1)
        return local @ pose.rotation.T + pose.translation_m, np.broadcast_to(normal, local.shape)

    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    outline = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    mesh = _fan(outline * (0.5, -0.5) + 0.5, at)
    return Patch(mesh=mesh, size_m=(2 * ry, 2 * rx), at=at)


def _fan(uvs: Array, at: Callable[[Array, Array], tuple[Array, Array]]) -> Mesh:
    """Return the mesh of a convex outline given by its texture coordinates (n, 2), counter-clockwise from outside."""
    points, normals = at(uvs[:, 0], uvs[:, 1])
    k = np.arange(1, len(uvs) - 1)[:, None]
    return Mesh(
        vertices=points.astype(np.float32),
        normals=np.asarray(normals, np.float32),
        uvs=uvs.astype(np.float32),
        triangles=np.hstack([np.zeros_like(k), k, k + 1]).astype(np.uint32),
    )


def board_patches(board: Solid, outline: Array) -> tuple[Patch, Patch]:
    """Return the front and the back of a sign's board whose outline (n, 2) is seen from its +x side.

    The front's texture is the square around the board, `board.size_m[1]` wide.
    """
    pose, depth, side = board.pose_world_solid(), board.size_m[0], board.size_m[1]

    def at_side(sign: float) -> Callable[[Array, Array], tuple[Array, Array]]:
        normal = pose.rotation @ np.array([sign, 0.0, 0.0])

        def at(u: Array, v: Array) -> tuple[Array, Array]:
            local = np.stack([np.full(len(u), sign * depth / 2), sign * side * (u - 0.5), side * (0.5 - v)], axis=1)
            return local @ pose.rotation.T + pose.translation_m, np.broadcast_to(normal, local.shape)

        return at

    uvs = np.stack([outline[:, 0] / side + 0.5, 0.5 - outline[:, 1] / side], axis=1)
    mirrored = np.stack([1 - uvs[::-1, 0], uvs[::-1, 1]], axis=1)
    front, back = (
        Patch(mesh=_fan(corners, at_side(sign)), size_m=(side, side), at=at_side(sign))
        for corners, sign in ((uvs, 1.0), (mirrored, -1.0))
    )
    return front, back
