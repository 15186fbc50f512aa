"""A scenario as lit rectangles: every static surface cut into patches whose light is a small picture."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.render.light import Lighting
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]
# The six faces of a box in its own frame: (normal axis, sign).
FACES = tuple((axis, sign) for axis in range(3) for sign in (1.0, -1.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Rectangle:
    """A flat rectangle: `corner` (3,) is its top left seen from the front; `right` and `down` (3,) span it, metres."""

    corner: Array
    right: Array
    down: Array

    @property
    def normal(self) -> Array:
        """The unit vector (3,) towards the viewer."""
        n = _cross(self.down, self.right)
        return n / math.sqrt(n @ n)

    def at(self, u: Array, v: Array) -> Array:
        """Return points (..., 3) at texture coordinates."""
        points: Array = self.corner + u[..., None] * self.right + v[..., None] * self.down
        return points

    def corners(self) -> Array:
        """Return (4, 3): top left, top right, bottom right, bottom left."""
        return self.at(np.array([0.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0, 1.0]))


def _cross(a: Array, b: Array) -> Array:
    """Return a x b of two vectors (3,); numpy's general one costs twenty times as much."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def floor_rectangle(bounds: tuple[float, float, float, float], z_m: float = 0.0) -> Rectangle:
    """Return the level rectangle x0, y0, x1, y1 seen from above, +y up in its picture."""
    x0, y0, x1, y1 = bounds
    return Rectangle(
        corner=np.array([x0, y1, z_m]), right=np.array([x1 - x0, 0.0, 0.0]), down=np.array([0.0, y0 - y1, 0.0])
    )


def box_faces(solid: Solid) -> Iterator[Rectangle]:
    """Yield the six faces of a solid, seen from outside."""
    pose, size = solid.pose_world_solid(), np.array(solid.size_m)
    for axis, sign in FACES:
        normal = np.zeros(3)
        normal[axis] = sign
        down = np.array([0.0, 0.0, -1.0]) if axis != 2 else np.array([-1.0, 0.0, 0.0])
        right = _cross(normal, down)
        corner = (normal * size - right * size - down * size) / 2
        yield Rectangle(
            corner=pose.transform(corner[None])[0],
            right=pose.rotation @ (right * size),
            down=pose.rotation @ (down * size),
        )


def screen_rectangle(panel: Solid) -> Rectangle:
    """Return a panel's lit screen: its +x face, a millimetre before it."""
    face = next(box_faces(panel))
    return Rectangle(corner=face.corner + 0.001 * face.normal, right=face.right, down=face.down)


def light_picture(lighting: Lighting, rectangle: Rectangle, texel_m: float) -> NDArray[np.float32]:
    """Return the irradiance (h, w, 4) float32 at texel centres."""
    width = max(1, round(float(np.linalg.norm(rectangle.right)) / texel_m))
    height = max(1, round(float(np.linalg.norm(rectangle.down)) / texel_m))
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    points = rectangle.at(u.ravel(), v.ravel())
    rgb = lighting.irradiance(points, np.broadcast_to(rectangle.normal, points.shape))
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = rgb.reshape(height, width, 3)
    return rgba


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """Triangles with texture coordinates: vertices (n, 3), normals (n, 3), uvs (n, 2), triangles (m, 3)."""

    vertices: NDArray[np.float32]
    normals: NDArray[np.float32]
    uvs: NDArray[np.float32]
    triangles: NDArray[np.uint32]


def rectangles_mesh(rectangles: Sequence[Rectangle], uv_boxes: Sequence[tuple[float, float, float, float]]) -> Mesh:
    """Return one mesh of rectangles, each with its part (u0, v0, u1, v1) of a shared texture."""
    uvs = [[(u0, v0), (u1, v0), (u1, v1), (u0, v1)] for u0, v0, u1, v1 in uv_boxes]
    quads = np.arange(len(rectangles))[:, None, None] * 4 + np.array([[0, 3, 2], [0, 2, 1]])
    return Mesh(
        vertices=np.concatenate([r.corners() for r in rectangles]).astype(np.float32),
        normals=np.repeat([r.normal for r in rectangles], 4, axis=0).astype(np.float32),
        uvs=np.array(uvs, np.float32).reshape(-1, 2),
        triangles=quads.reshape(-1, 3).astype(np.uint32),
    )


def grid_cells(
    xs: Sequence[float], ys: Sequence[float]
) -> Iterator[tuple[int, int, tuple[float, float, float, float]]]:
    """Yield (column, row, (x0, y0, x1, y1)) of the cells between rising borders."""
    for column, (x0, x1) in enumerate(itertools.pairwise(xs)):
        for row, (y0, y1) in enumerate(itertools.pairwise(ys)):
            yield column, row, (x0, y0, x1, y1)


def solids_atlas(lighting: Lighting, solids: Sequence[Solid], texel_m: float) -> tuple[Mesh, NDArray[np.float32]]:
    """Return one mesh of all the solids' faces and the atlas (h, w, 4) of their radiance (albedo included).

    Every face is a column strip of the atlas, bordered by copies of its outer texels.
    """
    faces = [(face, solid.albedo) for solid in solids for face in box_faces(solid)]
    shapes = [_face_texels(face, texel_m) for face, _ in faces]
    centres, normals = zip(
        *(_texel_centres(face, shape) for (face, _), shape in zip(faces, shapes, strict=True)), strict=True
    )
    rgb = lighting.irradiance(np.concatenate(centres), np.concatenate(normals))
    pictures = np.split(rgb, np.cumsum([h * w for h, w in shapes])[:-1])
    height, width = max(h for h, _ in shapes) + 2, sum(w + 2 for _, w in shapes)
    atlas, uv_boxes, column = np.ones((height, width, 4), np.float32), [], 0
    for (_, albedo), (h, w), picture in zip(faces, shapes, pictures, strict=True):
        lit = picture.reshape(h, w, 3) * np.array(albedo, np.float32)
        atlas[: h + 2, column : column + w + 2, :3] = np.pad(lit, ((1, 1), (1, 1), (0, 0)), mode="edge")
        uv_boxes.append(((column + 1) / width, 1 / height, (column + 1 + w) / width, (1 + h) / height))
        column += w + 2
    return rectangles_mesh([face for face, _ in faces], uv_boxes), atlas


def _face_texels(face: Rectangle, texel_m: float) -> tuple[int, int]:
    height, width = (int(np.clip(np.ceil(np.linalg.norm(edge) / texel_m), 1, 48)) for edge in (face.down, face.right))
    return height, width


def _texel_centres(face: Rectangle, shape: tuple[int, int]) -> tuple[Array, Array]:
    height, width = shape
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    points = face.at(u.ravel(), v.ravel())
    return points, np.broadcast_to(face.normal, points.shape)
