"""What a glossy floor mirrors: the lit hall as a small blurred picture, seen from the middle of its floor."""

import math
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.render.arena_parts import CEILING_ALBEDO, LAMP_RADIANCE, hall_bounds
from adc_bench.render.light import LAMP_GRID, LAMP_SIZE_M, Lighting
from adc_bench.render.parts import Light
from adc_bench.render.textures import WALL_KINDS

Array = NDArray[np.float64]
SIDE, SMOOTH_SIDE = 96, 32
BLUR_TEXELS = 2.0
WALL_SECOND_SHARE = 0.3  # of a wall's second colour, about
WINDOW_RADIANCE, WINDOW_WIDTH_RAD, WINDOW_LOW_M, WINDOW_HIGH_M = 4.0, 0.10, 1.2, 3.4


def hall_mirror(lighting: Lighting) -> Light:
    """Return the hall's radiance (h, w, 4) float32 over directions d from the middle of the floor, z up.

    Texture coordinates are d.xy / (1 + d.z) / 2 + 1/2, so that the rim is level. Walls, ceiling, lamps, and a bright
    window where each floodlight's light comes from.
    """
    half, height_m = hall_bounds(lighting.scenario)[2:], lighting.scenario.arena_spec.hall_height_m
    points, side, normals = _seen(half, height_m, SMOOTH_SIDE)
    light = (lighting.irradiance(points, normals) * _albedo(lighting, side)).astype(np.float32)
    smooth = cv2.resize(light.reshape(SMOOTH_SIDE, SMOOTH_SIDE, 3), (SIDE, SIDE))  # the lamps and windows are not
    points, side, _ = _seen(half, height_m, SIDE)
    shine = _lamps(lighting, points, side) + _windows(lighting, points, side)
    radiance = smooth + shine.reshape(SIDE, SIDE, 3).astype(np.float32)
    picture = cv2.GaussianBlur(radiance, (0, 0), BLUR_TEXELS)
    return np.asarray(np.insert(picture, 3, 0, axis=2), np.float32)


@lru_cache(maxsize=4)
def _seen(half_m: tuple[float, float], height_m: float, side_texels: int) -> tuple[Array, NDArray[np.intp], Array]:
    """Return the points (n, 3) of the hall that are seen, which wall, 0 or 1, or ceiling, 2, it is, and the normals."""
    v, u = np.meshgrid(*[(np.arange(side_texels) + 0.5) / side_texels * 2 - 1] * 2, indexing="ij")
    square = np.minimum(u**2 + v**2, 0.999)
    rays = np.stack([2 * u, 2 * v, 1 - square], axis=2).reshape(-1, 3) / (1 + square).reshape(-1, 1)
    walls = np.array(half_m) / np.maximum(np.abs(rays[:, :2]), 1e-6)
    ways = np.column_stack([walls, height_m / np.maximum(rays[:, 2], 1e-6)])
    side, points = ways.argmin(axis=1), rays * ways.min(axis=1, keepdims=True)
    normals = -np.sign(rays) * (np.arange(3) == side[:, None])
    for array in (points, side, normals):
        array.setflags(write=False)
    return points, side, normals


def _albedo(lighting: Lighting, side: NDArray[np.intp]) -> NDArray[np.float64]:
    wall = WALL_KINDS[lighting.scenario.look.wall]
    mixed = (1 - WALL_SECOND_SHARE) * np.array(wall.albedo) + WALL_SECOND_SHARE * np.array(wall.second)
    return np.where((side == 2)[:, None], CEILING_ALBEDO, mixed)


def _lamps(lighting: Lighting, points: NDArray[np.float64], side: NDArray[np.intp]) -> NDArray[np.float64]:
    up = np.flatnonzero(side == 2)
    near = [np.abs(points[up, :2] - place).max(axis=1) < LAMP_SIZE_M / 2 for place in LAMP_GRID]
    seen = np.zeros((len(points), 1))
    seen[up, 0] = np.any(near, axis=0)
    glow = LAMP_RADIANCE * lighting.lamp_share * lighting.level
    lamps: NDArray[np.float64] = seen * glow * lighting.warm
    return lamps


def _windows(lighting: Lighting, points: NDArray[np.float64], side: NDArray[np.intp]) -> NDArray[np.float64]:
    shine = np.zeros(len(points))
    high = (side < 2) & (points[:, 2] > WINDOW_LOW_M) & (points[:, 2] < WINDOW_HIGH_M)
    for flood in lighting.scenario.look.floods:
        off = np.arctan2(points[:, 1], points[:, 0]) - flood.azimuth_rad
        off = (off + math.pi) % (2 * math.pi) - math.pi
        shine += WINDOW_RADIANCE * flood.share * high * (np.abs(off) < WINDOW_WIDTH_RAD)
    return lighting.level * shine[:, None] * lighting.cold
