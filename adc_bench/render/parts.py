"""A part of the arena as every quality draws it: mesh, albedo without light, and light apart from it.

SAPIEN-free. `FastScene` multiplies the two; a physically based pack takes the albedo and lights it itself.
"""

from collections.abc import Callable, Hashable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.render.meshes import Mesh, Samples

Rgb = tuple[float, float, float]
Light = NDArray[np.float32]
DUST_ALBEDO: Rgb = (0.21, 0.20, 0.18)


@dataclass(frozen=True, kw_only=True)
class Plain:
    """One albedo everywhere."""

    albedo: Rgb

    def picture(self) -> NDArray[np.uint8]:
        """Return linear albedo (1, 1, 4) uint8 RGBA."""
        return _bytes(np.array([[self.albedo]]))


@dataclass(frozen=True, kw_only=True, eq=False)
class Painted:
    """A picture of linear albedo over the mesh's texture coordinates.

    Attributes:
        picture: draws it, (h, w, 4) uint8 RGBA.
        key: names it among all pictures; None where it belongs to one scenario alone.
    """

    picture: Callable[[], NDArray[np.uint8]]
    key: Hashable = None

    @classmethod
    def of_print(cls, draw: Callable[[], NDArray[np.uint8]], key: Hashable) -> "Painted":
        """Return a drawing (h, w, 3 or 4) uint8 in sRGB, printed, as albedo."""
        return cls(picture=lambda: _bytes(_PRINT_ALBEDO[draw()[..., :3]]), key=key)


@dataclass(frozen=True, kw_only=True, eq=False)
class TwoTone:
    """Two colours mixed by a picture over the mesh's texture coordinates.

    Attributes:
        draw: draws that picture, (h, w, 2) or (h, w, 4) uint8: tone of the first colour (128: the colour itself),
            share of the second, where the second wears off, where dust lies.
        key: names the picture, whatever the colours, the wear and the dirt.
    """

    draw: Callable[[], NDArray[np.uint8]]
    first: Rgb
    second: Rgb
    key: Hashable
    wear: float = 0.0
    dirt: float = 0.0

    def picture(self) -> NDArray[np.uint8]:
        """Return linear albedo (h, w, 4) uint8 RGBA; this is what the shader of the `fast` quality computes."""
        tones = self.draw().astype(np.float32) / 255
        second = tones[..., 1:2]
        if tones.shape[2] == 4:
            second = second * (1 - np.float32(self.wear) * tones[..., 2:3])
        albedo = 2 * tones[..., :1] * np.array(self.first, np.float32) * (1 - second)
        albedo += second * np.array(self.second, np.float32)
        if tones.shape[2] == 4:
            dust = np.float32(self.dirt) * tones[..., 3:4]
            albedo += dust * (np.array(DUST_ALBEDO, np.float32) - albedo)
        return _bytes(albedo)


@dataclass(frozen=True, kw_only=True, eq=False)
class Part:
    """One mesh of the arena with one surface.

    Attributes:
        name: a solid's or body's name where it stands for one.
        mesh: in the world, or in the frame of `body` where that is named.
        albedo: share of light given back.
        samples: where irradiance over the mesh's texture coordinates is sampled, in the mesh's frame; None for the
            floor, whose light `FloorLight` holds, and for a part that glows.
        glow: radiance of the albedo's white, for a part that shines by itself.
        label_id: in the label picture, 0 for the floor.
        texel_ids: (h, w) in its place, for a part of many things without a name: each texel's, as fine as its albedo.
        body: the body or tape that it moves with; None stands for good.
        gloss: share of a clear coat's mirror image.
        floor: whether the robot's shadow falls on it.
    """

    name: str
    mesh: Mesh
    albedo: Plain | Painted | TwoTone
    samples: Samples | None = None
    glow: float = 0.0
    label_id: int = 0
    texel_ids: NDArray[np.uint8] | None = None
    body: str | None = None
    gloss: float = 0.0
    floor: bool = False


def _linear(srgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return linear values of sRGB ones in [0, 1] (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


PRINT_WHITE = 0.85  # albedo of white print
_PRINT_ALBEDO = PRINT_WHITE * _linear(np.arange(256) / 255)


def _bytes(albedo: NDArray[np.floating]) -> NDArray[np.uint8]:
    rgb = cv2.convertScaleAbs(np.clip(albedo, 0, 1), alpha=255)
    return np.ascontiguousarray(np.dstack([rgb, np.full(rgb.shape[:2], 255, np.uint8)]))
