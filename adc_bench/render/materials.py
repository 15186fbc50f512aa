"""How our shader pack reads a material: the only file that knows its slots (shaders/arena/gbuffer.frag)."""

import ctypes
import sys
from collections import OrderedDict
from collections.abc import Callable, Hashable

import numpy as np
import sapien
from numpy.typing import NDArray

from adc_bench.render.parts import Light, Painted, Part, Plain, TwoTone

STORE_BYTES = 180_000_000  # floors and walls come back from scenario to scenario: a family's six floors take 150 MB
LARGE_BYTES = 10_000_000  # of a floor that carries paint
_FORMATS = {1: "R8Unorm", 2: "R8G8Unorm", 4: "R8G8B8A8Unorm"}


def _give_back_freed() -> None:
    """Let glibc return freed memory to the system: what a floor is drawn with would stay behind, between textures."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim:
        trim(0)


class TextureStore:
    """Textures that come back, by name; the ones not used for longest go first."""

    def __init__(self, bytes_max: int) -> None:
        self._bytes_max, self._bytes = bytes_max, 0
        self._kept = OrderedDict[Hashable, tuple[sapien.render.RenderTexture2D, int]]()

    def get(self, key: Hashable, draw: Callable[[], NDArray[np.uint8]]) -> sapien.render.RenderTexture2D:
        """Return the texture of this name, drawing it when it is not here."""
        if key not in self._kept:
            picture = draw()
            self._kept[key] = mipmapped(picture), picture.nbytes
            self._bytes += picture.nbytes
            if picture.nbytes > LARGE_BYTES:
                _give_back_freed()
        self._kept.move_to_end(key)
        while self._bytes > self._bytes_max and len(self._kept) > 1:
            _, (_, freed) = self._kept.popitem(last=False)
            self._bytes -= freed
        return self._kept[key][0]


_STORE = TextureStore(STORE_BYTES)


def mipmapped(picture: NDArray[np.uint8]) -> sapien.render.RenderTexture2D:
    """Return a texture of a picture (h, w, channels) with its smaller copies."""
    levels = max(1, int(np.log2(min(picture.shape[:2]))) - 1)
    return sapien.render.RenderTexture2D(
        np.ascontiguousarray(picture), _FORMATS[picture.shape[2]], mipmap_levels=levels, address_mode="edge"
    )


def light_texture(light: Light) -> sapien.render.RenderTexture2D:
    """Return a texture of light (h, w, 4)."""
    return sapien.render.RenderTexture2D(np.ascontiguousarray(light), "R32G32B32A32Sfloat", address_mode="edge")


def texture_of(albedo: Painted | TwoTone) -> sapien.render.RenderTexture2D:
    """Return the texture that a surface is drawn with, from the store if it has a name."""
    draw = albedo.picture if isinstance(albedo, Painted) else albedo.draw
    if albedo.key is None:
        return mipmapped(draw())
    return _STORE.get(albedo.key, draw)


def lit(albedo: NDArray[np.uint8], light: Light, texel_ids: NDArray[np.uint8] | None = None) -> Light:
    """Return light (h, w, 4) times albedo (h, w, 4) uint8; alpha carries each texel's label id where there are some."""
    radiance = np.asarray(light * (albedo.astype(np.float32) / np.float32(255)), np.float32)
    if texel_ids is not None:
        radiance[..., 3] = texel_ids / np.float32(255)
    return radiance


def floor_material(
    part: Part, light: sapien.render.RenderTexture2D, mirror: sapien.render.RenderTexture2D
) -> sapien.render.RenderMaterial:
    """Return the material of a part of the floor: the robot's shadow falls on it, and the hall shows in it."""
    material = material_of(part, light)
    material.set_transmission(1.0)
    material.set_specular(part.gloss)
    material.set_roughness_texture(mirror)
    return material


def material_of(part: Part, light: sapien.render.RenderTexture2D | None) -> sapien.render.RenderMaterial:
    """Return a part's material, its light in a texture already (none for one that glows)."""
    albedo = part.albedo
    scale = part.glow if part.glow else 1.0
    if isinstance(albedo, TwoTone):
        colour, second, mode = [2 * c for c in albedo.first], albedo.second, 1.0
    elif isinstance(albedo, Plain):
        colour, second, mode = [scale * c for c in albedo.albedo], (0.0, 0.0, 0.0), 0.0
    else:
        colour, second, mode = [scale] * 3, (0.0, 0.0, 0.0), 0.0
    material = sapien.render.RenderMaterial(
        base_color=[*colour, 1.0], emission=[*second, 1.0], roughness=part.label_id / 255, metallic=mode
    )
    if not isinstance(albedo, Plain):
        material.set_base_color_texture(texture_of(albedo))
    if light is not None:
        material.set_emission_texture(light)
    if isinstance(albedo, TwoTone):
        material.set_ior(albedo.wear)
        material.set_transmission_roughness(albedo.dirt)
    return material


def baked_material(radiance_texture: sapien.render.RenderTexture2D, label_id: int) -> sapien.render.RenderMaterial:
    """Return the material of a part whose albedo and light are multiplied already."""
    material = sapien.render.RenderMaterial(base_color=[1.0] * 4, roughness=label_id / 255, metallic=0.0)
    material.set_emission_texture(radiance_texture)
    return material
