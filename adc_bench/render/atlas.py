"""Many patches of solids as one mesh with one picture of albedo and one of light."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.render.meshes import TEXELS_MAX, Mesh, Patch, Samples, joined, patches
from adc_bench.world.solids import Shape, Solid

Array = NDArray[np.float64]
WIDTH_TEXELS = 256  # at most


@dataclass(frozen=True, kw_only=True, eq=False)
class Covering:
    """The patches of one thing at one texel size.

    Attributes:
        mesh: of all of them, each with texture coordinates over the unit square.
        of_vertex: (n,) which patch each vertex belongs to.
        shapes: (patches, 2) each one's light picture's height and width.
        points: (m, 3) the texels' centres, one patch after the other.
        normals: (m, 3) there.
    """

    mesh: Mesh
    of_vertex: NDArray[np.int32]
    shapes: NDArray[np.int32]
    points: Array
    normals: Array

    @classmethod
    def of(cls, of_all: Sequence[Patch], texel_m: float) -> "Covering":
        """Return the covering of patches."""
        shapes = [patch.texels(texel_m) for patch in of_all]
        centres = [patch.texel_centres(shape) for patch, shape in zip(of_all, shapes, strict=True)]
        vertices = [len(patch.mesh.vertices) for patch in of_all]
        return cls(
            mesh=joined([patch.mesh for patch in of_all]),
            of_vertex=np.repeat(np.arange(len(of_all), dtype=np.int32), vertices),
            shapes=np.array(shapes, np.int32),
            points=np.concatenate([points for points, _ in centres]),
            normals=np.concatenate([normals for _, normals in centres]),
        )

    def moved(self, pose: Pose3) -> "Covering":
        """Return the covering in the outer frame."""
        points = np.einsum("ij,kj->ik", self.points, pose.rotation) + pose.translation_m
        normals = np.einsum("ij,kj->ik", self.normals, pose.rotation)
        return replace(self, mesh=self.mesh.moved(pose), points=points, normals=normals)


def covering_of(solid: Solid, texel_m: float) -> Covering:
    """Return a solid's covering, where its pose puts it."""
    return _own_covering(solid.shape, solid.size_m, texel_m).moved(solid.pose_world_solid())


@lru_cache(maxsize=256)
def _own_covering(shape: Shape, size_m: tuple[float, float, float], texel_m: float) -> Covering:
    """Return a covering in the solid's own frame: most things in a hall come in a few sizes."""
    solid = Solid(name="", kind="box", shape=shape, centre_m=(0.0, 0.0, 0.0), size_m=size_m)
    return Covering.of(list(patches(solid)), texel_m)


@dataclass(frozen=True, kw_only=True, eq=False)
class Atlas:
    """Patches laid out in shelves of one picture, each with a border of copies of its outer texels.

    Attributes:
        mesh: of all patches.
        samples: where its light is sampled, in the mesh's frame.
        albedo: (h, w, 4) uint8 RGBA, linear.
        of_patch: (h, w) which patch each texel belongs to.
    """

    mesh: Mesh
    samples: Samples
    albedo: NDArray[np.uint8]
    of_patch: NDArray[np.int32]

    @classmethod
    def of(cls, solids: Sequence[Solid], texel_m: float) -> "Atlas":
        """Return the atlas of solids, at about this texel size."""
        return cls.of_coverings([covering_of(solid, texel_m) for solid in solids], [solid.albedo for solid in solids])

    @classmethod
    def of_coverings(cls, coverings: Sequence[Covering], albedos: Sequence[tuple[float, float, float]]) -> "Atlas":
        """Return the atlas of coverings with one albedo each."""
        shapes = np.concatenate([covering.shapes for covering in coverings])
        corners, (height, width) = _shelves(shapes.tolist())
        counts = shapes.prod(axis=1)
        index = np.zeros((height, width), np.int32)
        firsts = (np.cumsum(counts) - counts).tolist()
        for first, (h, w), (row, column) in zip(firsts, shapes.tolist(), corners, strict=True):
            rows, columns = _bordered(h), _bordered(w)
            index[row : row + h + 2, column : column + w + 2] = first + w * rows[:, None] + columns
        mesh = joined([covering.mesh for covering in coverings])
        patch_counts = [len(covering.shapes) for covering in coverings]
        first_patch = np.repeat(np.cumsum(patch_counts) - patch_counts, [len(c.of_vertex) for c in coverings])
        of_vertex = first_patch + np.concatenate([covering.of_vertex for covering in coverings])
        uvs = (np.array(corners)[:, ::-1] + 1)[of_vertex] + mesh.uvs * shapes[:, ::-1][of_vertex]
        rgba = np.array([[*np.round(np.array(albedo) * 255), 255] for albedo in albedos]).astype(np.uint8)
        of_patch = np.repeat(np.arange(len(shapes), dtype=np.int32), counts)[index]
        return cls(
            mesh=replace(mesh, uvs=(uvs / (width, height)).astype(np.float32)),
            samples=Samples(
                points=np.concatenate([covering.points for covering in coverings]),
                normals=np.concatenate([covering.normals for covering in coverings]),
                index=index,
            ),
            albedo=np.repeat(rgba, patch_counts, axis=0)[of_patch],
            of_patch=of_patch,
        )


@lru_cache(maxsize=TEXELS_MAX)
def _bordered(count: int) -> NDArray[np.int32]:
    """Return 0, 0, 1, .. count - 1, count - 1."""
    return np.array([0, *range(count), count - 1], np.int32)


def _shelves(shapes: Sequence[tuple[int, int]]) -> tuple[list[tuple[int, int]], tuple[int, int]]:
    """Return the corner (row, column) of each patch with its border, and the picture's shape."""
    corners = [(0, 0)] * len(shapes)
    row, column, shelf, widest = 0, 0, 0, 0
    for k in sorted(range(len(shapes)), key=lambda k: (-shapes[k][0], k)):
        height, width = shapes[k][0] + 2, shapes[k][1] + 2
        if column + width > WIDTH_TEXELS:
            row, column, shelf = row + shelf, 0, 0
        corners[k] = (row, column)
        column, shelf = column + width, max(shelf, height)
        widest = max(widest, column)
    return corners, (row + shelf, widest)
