"""Many patches of solids as one mesh with one picture of albedo and one of light."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from adc_bench.render.meshes import TEXELS_MAX, Mesh, Patch, Samples, joined, patches
from adc_bench.world.solids import Solid

WIDTH_TEXELS = 256  # at most


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
        of_all = [(patch, solid.albedo) for solid in solids for patch in patches(solid)]
        return cls.of_patches([p for p, _ in of_all], [a for _, a in of_all], texel_m)

    @classmethod
    def of_patches(
        cls, of_all: Sequence[Patch], albedos: Sequence[tuple[float, float, float]], texel_m: float
    ) -> "Atlas":
        """Return the atlas of patches with one albedo each."""
        shapes = [patch.texels(texel_m) for patch in of_all]
        corners, (height, width) = _shelves(shapes)
        index = np.zeros((height, width), np.int32)
        meshes, first = [], 0
        for patch, (h, w), (row, column) in zip(of_all, shapes, corners, strict=True):
            rows, columns = _bordered(h), _bordered(w)
            index[row : row + h + 2, column : column + w + 2] = first + w * rows[:, None] + columns
            u0, v0 = (column + 1) / width, (row + 1) / height
            meshes.append(patch.mesh.within((u0, v0, u0 + w / width, v0 + h / height)))
            first += h * w
        centres = [patch.texel_centres(shape) for patch, shape in zip(of_all, shapes, strict=True)]
        counts = [h * w for h, w in shapes]
        colours = np.repeat(np.array(albedos), counts, axis=0)
        rgba = np.column_stack([np.round(colours * 255), np.full(len(colours), 255)]).astype(np.uint8)
        return cls(
            mesh=joined(meshes),
            samples=Samples(
                points=np.concatenate([points for points, _ in centres]),
                normals=np.concatenate([normals for _, normals in centres]),
                index=index,
            ),
            albedo=rgba[index],
            of_patch=np.repeat(np.arange(len(shapes), dtype=np.int32), counts)[index],
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
