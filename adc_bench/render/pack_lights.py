"""The light of a scenario as SAPIEN's lights, in the unit of `light.py`: radiance 1 is a white surface under 300 lux.

Floodlights stand a kilometre away, so that their light is parallel over the hall to a percent.
"""

import math
from collections.abc import Iterator

import numpy as np
import sapien
from numpy.typing import NDArray

from adc_bench.render.light import HALL_M2, LAMP_GRID, LAMP_SIZE_M, PENUMBRA_RAD, Lighting, direction
from adc_bench.world.look import Flood

Array = NDArray[np.float64]
FAR_M = 1000.0
FIELD_M = 13.0  # radius about the hall's middle in which a floodlight casts shadows
SHADOW_MAP_PX = 2048


def shadowing_floods(lighting: Lighting) -> Iterator[sapien.Entity]:
    """Yield the floodlights as spotlights with shadow maps (the default pack maps one directional light at most)."""
    for flood in lighting.scenario.look.floods:
        light = sapien.render.RenderSpotLightComponent()
        light.set_color((math.pi * FAR_M**2 * _normal_irradiance(lighting, flood)).tolist())
        light.set_outer_fov(2 * math.atan(1.5 * FIELD_M / FAR_M))
        light.set_inner_fov(2 * math.atan(FIELD_M / FAR_M))
        light.shadow, light.shadow_map_size = True, SHADOW_MAP_PX
        light.shadow_near, light.shadow_far = FAR_M - 2 * FIELD_M, FAR_M + 2 * FIELD_M
        yield _shining(light, FAR_M * direction(flood.azimuth_rad, flood.elevation_rad), np.zeros(3))


def glowing_floods(lighting: Lighting) -> Iterator[sapien.Entity]:
    """Yield the floodlights as squares that look as large as `PENUMBRA_RAD` says."""
    side = 2 * PENUMBRA_RAD * FAR_M
    for flood in lighting.scenario.look.floods:
        radiance = math.pi * _normal_irradiance(lighting, flood) * FAR_M**2 / side**2
        place = FAR_M * direction(flood.azimuth_rad, flood.elevation_rad)
        yield _shining(_square(side, radiance), place, np.zeros(3))


def glowing_lamps(lighting: Lighting) -> Iterator[sapien.Entity]:
    """Yield the ceiling's lamps as squares that shine down."""
    strength = lighting.level * lighting.lamp_share * lighting.warm
    radiance = strength * HALL_M2 / len(LAMP_GRID) / LAMP_SIZE_M**2
    for place in lighting.lamps:
        yield _shining(_square(LAMP_SIZE_M, radiance), place, place - (0.0, 0.0, 1.0))


def sky_radiance(lighting: Lighting) -> Array:
    """Return the radiance (3,) of the even sky, the bounced light of the hall."""
    return lighting.level * lighting.sky_share * lighting.warm


def _normal_irradiance(lighting: Lighting, flood: Flood) -> Array:
    """Return the irradiance (3,) of a surface that faces the floodlight; its share is that of the level floor."""
    return lighting.level * flood.share / math.sin(flood.elevation_rad) * lighting.cold


def _square(side_m: float, radiance: Array) -> sapien.render.RenderParallelogramLightComponent:
    light = sapien.render.RenderParallelogramLightComponent()
    light.set_shape(side_m / 2, side_m / 2)
    light.set_color(radiance.tolist())
    return light


def _shining(light: sapien.render.RenderLightComponent, place: Array, at: Array) -> sapien.Entity:
    """Return the light standing at a place and facing a point: SAPIEN's lights shine along their x axis."""
    x = (at - place) / np.linalg.norm(at - place)
    y = np.cross([0.0, 0.0, 1.0] if abs(x[2]) < 0.9 else [0.0, 1.0, 0.0], x)
    y /= np.linalg.norm(y)
    matrix = np.eye(4, dtype=np.float32)
    matrix[:3, :3], matrix[:3, 3] = np.stack([x, y, np.cross(x, y)], axis=1), place
    entity = sapien.Entity()
    entity.add_component(light)
    entity.set_pose(sapien.Pose(matrix))
    return entity
