"""Parts of the arena as materials of SAPIEN's own packs: albedo in the base colour, baked light in the emission."""

from functools import lru_cache

import cv2
import numpy as np
import sapien
from numpy.typing import NDArray

from adc_bench.render.light import Lighting
from adc_bench.render.meshes import Samples
from adc_bench.render.parts import Light, Painted, Part, Plain, TwoTone

# SAPIEN's packs reflect 0.08 of `specular` head-on, a clear coat of lacquer 0.04. Half of that, because a traced floor
# mirrors the even sky, which is brighter than the walls in its place.
COAT_SPECULAR, COAT_ROUGHNESS = 0.25, 0.3


def light_at(lighting: Lighting, samples: Samples) -> Light:
    """Return the light picture (h, w, 4) at samples in the world."""
    return samples.picture(lighting.irradiance(samples.points, samples.normals))


def reflecting(part: Part) -> sapien.render.RenderMaterial:
    """Return the material of a part that lights fall on."""
    material = sapien.render.RenderMaterial(
        specular=COAT_SPECULAR * part.gloss, roughness=COAT_ROUGHNESS if part.gloss else 1.0
    )
    material.set_base_color_texture(albedo_texture(part.albedo))
    return material


def give_back(material: sapien.render.RenderMaterial, part: Part, light: Light) -> None:
    """Let a part's material also give back light (h, w, 4) that no lamp of the scene throws on it."""
    material.set_emission([1.0] * 4)
    material.set_emission_texture(emission_texture(part, light))


def glowing(part: Part, light: Light | None) -> sapien.render.RenderMaterial:
    """Return the material of a part that shines by itself, or with light (h, w, 4) that fell on it, and no other."""
    level = part.glow or 1.0
    material = sapien.render.RenderMaterial(base_color=[0.0, 0.0, 0.0, 1.0], emission=[level, level, level, 1.0])
    texture = albedo_texture(part.albedo) if light is None else emission_texture(part, light)
    material.set_emission_texture(texture)
    return material


def albedo_texture(albedo: Plain | Painted | TwoTone) -> sapien.render.RenderTexture2D:
    """Return the texture of linear albedo."""
    picture = _picture_of(albedo)
    return sapien.render.RenderTexture2D(
        picture, "R8G8B8A8Unorm", mipmap_levels=_levels(albedo, picture.shape), address_mode="edge"
    )


def emission_texture(part: Part, light: Light) -> sapien.render.RenderTexture2D:
    """Return the texture of light (h, w, 4) times albedo, as fine as the finer of the two."""
    albedo = _picture_of(part.albedo).astype(np.float32)
    size = max(albedo.shape[1], light.shape[1]), max(albedo.shape[0], light.shape[0])
    picture = _resized(albedo, size) * (_resized(light, size) / np.float32(255))
    return sapien.render.RenderTexture2D(
        picture.astype(np.float16),
        "R16G16B16A16Sfloat",
        mipmap_levels=_levels(part.albedo, picture.shape),
        address_mode="edge",
    )


@lru_cache(maxsize=2)  # both parts of the course, each with its albedo and its light, need one large picture
def _picture_of(albedo: Plain | Painted | TwoTone) -> NDArray[np.uint8]:
    return albedo.picture()


def _resized(picture: Light, size: tuple[int, int]) -> Light:
    is_right = (picture.shape[1], picture.shape[0]) == size
    return picture if is_right else np.asarray(cv2.resize(picture, size), np.float32)


def _levels(albedo: Plain | Painted | TwoTone, shape: tuple[int, ...]) -> int:
    """Return how many smaller copies a texture has: none for an atlas, whose patches they would mix."""
    is_atlas = isinstance(albedo, Painted) and albedo.key is None
    return 1 if is_atlas else max(1, int(np.log2(min(shape[:2]))) - 1)
