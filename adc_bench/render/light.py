"""Light of one scenario, computed once: irradiance at points of the static surfaces.

The unit is 300 lux, so a white surface in an ordinarily lit hall has radiance about 1. Light comes from an even sky
(the hall's bounced light), ceiling lamps and one floodlight or window far away, which alone casts sharp shadows.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Path
from adc_bench.world.arena import road_centre, tunnel_s_on_centre
from adc_bench.world.look import Look
from adc_bench.world.scenario import Scenario
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]
UNIT_LUX = 300.0
PENUMBRA_RAD = 0.025  # half the angle under which the floodlight appears
LAMP_GRID = tuple((x, y) for x in (-7.0, 0.0, 7.0) for y in (-3.5, 3.5))
TUNNEL_FLOOR_SHARE = 0.015  # light deep inside, relative to outside
TUNNEL_REACH_M = 0.7  # e-folding depth of daylight behind an opening


@dataclass(frozen=True, kw_only=True, eq=False)
class Blocker:
    """A box that casts a shadow: centre (3,), axes as columns (3, 3), half size (3,), bounding radius."""

    centre: Array
    rotation: Array
    half: Array
    radius_m: float

    @classmethod
    def of(cls, solid: Solid) -> "Blocker":
        """Return the solid as a blocker."""
        pose, half = solid.pose_world_solid(), np.array(solid.size_m) / 2
        return cls(centre=pose.translation_m, rotation=pose.rotation, half=half, radius_m=float(np.linalg.norm(half)))


@dataclass(frozen=True, kw_only=True)
class Lighting:
    """The lamps of a scenario and what stands in their way."""

    scenario: Scenario

    def irradiance(self, points: Array, normals: Array) -> NDArray[np.float32]:
        """Return irradiance rgb (n, 3) in units of 300 lux at world points (n, 3) with unit normals (n, 3)."""
        look = self.scenario.look
        level = look.illuminance_lux / UNIT_LUX
        warm, cold = _white_of(look.colour_temperature_k), _white_of(look.colour_temperature_k * 1.15)
        diffuse = (1 - look.flood_share) * (
            (1 - look.lamp_share) * _sky(normals) + look.lamp_share * _lamps(points, normals, self._lamp_height_m)
        )
        diffuse *= self._openness(points + 0.02 * normals)
        flood = look.flood_share * self._flood(points + 0.005 * normals, normals)
        light = level * (diffuse[:, None] * warm + flood[:, None] * cold)
        return np.asarray(light, dtype=np.float32)

    @property
    def _lamp_height_m(self) -> float:
        return self.scenario.arena_spec.hall_height_m - 0.1

    @cached_property
    def _blockers(self) -> list[Blocker]:
        return [Blocker.of(solid) for solid in self.scenario.solids if solid.kind != "wall"]

    def _flood(self, points: Array, normals: Array) -> Array:
        """Return the floodlight's share, 1 on open floor: cosine law times the visible part of the lamp."""
        look = self.scenario.look
        towards = _direction(look.flood_azimuth_rad, look.flood_elevation_rad)
        share: Array = np.clip(normals @ towards, 0.0, None) / towards[2]
        facing = np.flatnonzero(share)
        lit = np.zeros(len(facing))
        for da, de in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
            ray = _direction(
                look.flood_azimuth_rad + da * PENUMBRA_RAD / 2, look.flood_elevation_rad + de * PENUMBRA_RAD / 2
            )
            lit += ~_shadowed(points[facing], ray, self._blockers)
        share[facing] *= lit / 4
        return share

    def _openness(self, points: Array) -> Array:
        """Return the share of diffuse light that reaches each point: less inside the tunnel."""
        openness = np.ones(len(points))
        tunnel = self.scenario.tunnel
        if tunnel is None:
            return openness
        spec, course = self.scenario.arena_spec, self.scenario.course
        s0, s1 = tunnel_s_on_centre(course, tunnel)
        centre = road_centre(course)
        half, around = spec.tunnel_clear_half_width_m + spec.tunnel_wall_m / 2, (s0 + s1) / 2
        near = _near_path(points, centre, s0, s1, half)
        s, offset = centre.project(points[near, :2], around_s_m=around, window_m=(s1 - s0) / 2 + 0.5)
        inside = (np.abs(offset) < half) & (s > s0) & (s < s1) & (points[near, 2] < spec.tunnel_height_m)
        daylight = 0.5 * (np.exp(-(s - s0) / TUNNEL_REACH_M) + np.exp(-(s1 - s) / TUNNEL_REACH_M))
        openness[near] = np.where(inside, TUNNEL_FLOOR_SHARE + daylight, 1.0)
        return openness


def _near_path(points: Array, centre: Path, s0: float, s1: float, half: float) -> NDArray[np.intp]:
    way = centre.poses(np.linspace(s0, s1, 24))[:, :2]
    (x0, y0), (x1, y1) = way.min(axis=0) - half, way.max(axis=0) + half
    x, y = points[:, 0], points[:, 1]
    return np.flatnonzero((x > x0) & (x < x1) & (y > y0) & (y < y1))


def _direction(azimuth_rad: float, elevation_rad: float) -> Array:
    """Return the unit vector towards a far light."""
    level = math.cos(elevation_rad)
    return np.array([level * math.cos(azimuth_rad), level * math.sin(azimuth_rad), math.sin(elevation_rad)])


def _sky(normals: Array) -> Array:
    """Return the share of an even sky above a floor that gives back a fifth: 1 facing up, 0.2 facing down."""
    share: Array = 0.6 + 0.4 * normals[:, 2]
    return share


def _lamps(points: Array, normals: Array, height_m: float) -> Array:
    """Return the lamps' share, about 1 on average on the floor, by the inverse square and both cosines."""
    total = np.zeros(len(points))
    for x, y in LAMP_GRID:
        to_lamp = np.array([x, y, height_m]) - points
        square = np.einsum("ij,ij->i", to_lamp, to_lamp) + 0.25
        cosines = np.clip(np.einsum("ij,ij->i", to_lamp, normals), 0.0, None) * np.clip(to_lamp[:, 2], 0.0, None)
        total += cosines / square**2
    hall_m2 = 300.0  # flux that lands on the hall's floor is spread over about this area
    share: Array = total / math.pi * hall_m2 / len(LAMP_GRID) + 0.25 * _sky(normals)
    return share


def _shadowed(points: Array, towards: Array, blockers: Sequence[Blocker]) -> NDArray[np.bool_]:
    """Return for each point (n, 3) whether a box stands between it and a far light (slab test, culled by spheres)."""
    side = np.cross(towards, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    across = np.stack([side, np.cross(side, towards)], axis=1)
    centres = np.array([blocker.centre for blocker in blockers]) @ across
    radii = np.array([blocker.radius_m for blocker in blockers])
    low, high = (centres - radii[:, None]).min(axis=0), (centres + radii[:, None]).max(axis=0)
    u, v = points @ across[:, 0], points @ across[:, 1]
    some = np.flatnonzero((u > low[0]) & (u < high[0]) & (v > low[1]) & (v < high[1]))
    u, v = u[some], v[some]
    hit = np.zeros(len(points), bool)
    for blocker, (cu, cv), radius in zip(blockers, centres, radii, strict=True):
        near = some[(np.abs(u - cu) < radius) & (np.abs(v - cv) < radius)]
        if len(near):
            local = (points[near] - blocker.centre) @ blocker.rotation
            ray = towards @ blocker.rotation
            hit[near] |= _ray_meets_box(local, np.where(np.abs(ray) < 1e-12, 1e-12, ray), blocker.half)
    return hit


def _ray_meets_box(origins: Array, ray: Array, half: Array) -> NDArray[np.bool_]:
    """Return whether rays (3,) from points (n, 3) meet the box of half size (3,) about the origin, ahead of them."""
    middle, reach = -origins / ray, half / np.abs(ray)
    enter, leave = middle - reach, middle + reach
    first = np.maximum(np.maximum(enter[:, 0], enter[:, 1]), enter[:, 2])
    last = np.minimum(np.minimum(leave[:, 0], leave[:, 1]), leave[:, 2])
    meets: NDArray[np.bool_] = last > np.maximum(first, 1e-6)
    return meets


def _white_of(kelvin: float) -> Array:
    """Return linear rgb of a black body with green = 1, half corrected towards white as a camera's balance does.

    A rough fit to the black-body locus in linear sRGB from 2,500 K to 8,000 K (within a fifth).
    """
    x = math.log(kelvin / 6600.0)
    white: Array = np.sqrt([math.exp(-1.05 * x), 1.0, math.exp(1.35 * x)])
    return white


def exposure_for(look: Look, irradiance: float) -> float:
    """Return the exposure a camera settles on when the floor before it gets this irradiance (unit 300 lux).

    White paint comes out at 0.7 of full scale; below 60 lux the gain is at its end and the picture stays dark.
    """
    darkest = 60.0 / UNIT_LUX
    return 0.875 / max(irradiance, darkest) * math.pow(2.0, look.exposure_bias_ev)
