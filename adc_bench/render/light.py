"""Light of one scenario: irradiance at points of its surfaces, computed once and put into pictures.

The unit is 300 lux, so a white surface in an ordinarily lit hall has radiance about 1. Light comes from an even sky
(the hall's bounced light), ceiling lamps, and floodlights or windows far away.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Path
from adc_bench.render.shadows import Blockers, Outlines, shadowed
from adc_bench.world.arena import road_centre, tunnel_s_on_centre
from adc_bench.world.look import Flood
from adc_bench.world.scenario import Scenario

Array = NDArray[np.float64]
Floats = NDArray[np.float64] | NDArray[np.float32]
UNIT_LUX = 300.0
PENUMBRA_RAD = 0.025  # half the angle under which a floodlight appears
CORNERS = ((-1, -1), (-1, 1), (1, -1), (1, 1))  # the four rays to a light that has a size
LAMP_GRID = tuple((x, y) for x in (-7.0, 0.0, 7.0) for y in (-3.5, 3.5))
LAMP_SIZE_M = 0.7
LAMP_BOUNCE = 0.25  # of the lamps' light: what comes back from walls and ceiling, evenly
HALL_M2 = 300.0  # the flux that lands on the hall's floor is spread over about this area
UPRIGHT_LOSS = 0.5  # of a floodlight's beam
LAMP_GAIN_M2 = HALL_M2 / len(LAMP_GRID) / math.pi
LAMP_SOFT_M2 = 0.25  # a lamp is no point
FAINT = 0.008  # of the lamps' share on the open floor: about a step of 255 of all light
TUNNEL_FLOOR_SHARE = 0.015  # light deep inside, relative to outside
TUNNEL_REACH_M = 0.7  # e-folding depth of daylight behind an opening
ROAD_TEXELS = 4  # of the floor's light; between them the place on the road is taken to change evenly
MOUTH_M, MOUTH_REACH_M = 1.5, 0.25  # how far before a mouth the tunnel takes light away; e-folding length
GROUND_SHADE, GROUND_REACH_M = 0.3, 0.12  # upright surfaces are darker near the floor


@dataclass(frozen=True, kw_only=True)
class Lighting:
    """The lamps of a scenario and what stands for good in their way."""

    scenario: Scenario

    @property
    def level(self) -> float:
        """The open floor's irradiance."""
        return self.scenario.look.illuminance_lux / UNIT_LUX

    @property
    def warm(self) -> Array:
        """Colour (3,) of the lamps and of bounced light, green = 1."""
        return white_of(self.scenario.look.colour_temperature_k)

    @property
    def cold(self) -> Array:
        """Colour (3,) of the floodlights, green = 1."""
        return white_of(self.scenario.look.colour_temperature_k * 1.15)

    @property
    def sky_share(self) -> float:
        """Share of even light, the lamps' bounced light in it."""
        look = self.scenario.look
        return (1 - look.flood_share) * (1 - look.lamp_share + LAMP_BOUNCE * look.lamp_share)

    @property
    def lamp_share(self) -> float:
        """Share of light straight from the ceiling's lamps."""
        look = self.scenario.look
        return (1 - look.flood_share) * look.lamp_share

    @property
    def lamp_height_m(self) -> float:
        """How high the lamps hang."""
        return self.scenario.arena_spec.hall_height_m - 0.1

    def irradiance(self, points: Array, normals: Array) -> NDArray[np.float32]:
        """Return irradiance rgb (n, 3) in units of 300 lux at world points (n, 3) with unit normals (n, 3)."""
        diffuse, coarse = self.sky_share * sky(normals), (points.astype(np.float32), normals.astype(np.float32))
        for place in self.lamps:
            diffuse += self.lamp_share * lamp(*coarse, place.astype(np.float32))
        diffuse *= self.openness(points + 0.02 * normals)
        upright = 1 - normals[:, 2] ** 2
        diffuse *= 1 - GROUND_SHADE * upright * np.exp(-np.maximum(points[:, 2], 0.0) / GROUND_REACH_M)
        floods = sum(self._flood(points + 0.005 * normals, normals, flood) for flood in self.scenario.look.floods)
        light = self.level * (diffuse[:, None] * self.warm + np.multiply.outer(floods, self.cold))
        return np.asarray(light, dtype=np.float32)

    @cached_property
    def lamps(self) -> tuple[Array, ...]:
        """The lamps' places (3,)."""
        return tuple(np.array([x, y, self.lamp_height_m]) for x, y in LAMP_GRID)

    @cached_property
    def standing(self) -> Outlines:
        """What stands for good and throws shadows."""
        return Outlines.of([solid for solid in self.scenario.solids if solid.kind not in ("wall", "poster")])

    @cached_property
    def rays(self) -> Array:
        """The lights' rays (k, 4) for `shadow_points`: four to each floodlight, then four to each lamp."""
        floods = [(*ray, 0.0) for flood in self.scenario.look.floods for ray in flood_rays(flood)]
        half = LAMP_SIZE_M / 2
        lamps = [(x + dx * half, y + dy * half, z, 1.0) for x, y, z in self.lamps for dx, dy in CORNERS]
        return np.array([*floods, *lamps])

    def casts(self, outlines: Outlines) -> NDArray[np.bool_]:
        """Return whether each of `rays` and each solid (k, n) make a shadow on the floor.

        What a tunnel takes from the lamps is in the openness, and a far lamp's light is too faint to be missed.
        """
        x, y, _ = outlines.points.T
        faint = [lamp_share_at(x, y, place) < FAINT for place in self.lamps]
        lamps = np.logical_or.reduceat(~np.array(faint), outlines.starts[:-1], axis=1)
        lamps &= [solid.kind != "tunnel" for solid in outlines.solids]
        floods = np.ones((len(self.scenario.look.floods), len(outlines.solids)), bool)
        return np.repeat(np.concatenate([floods, lamps]), len(CORNERS), axis=0)

    @cached_property
    def standing_shadows(self) -> Array:
        """Where the shadows of `standing`'s points fall on the floor (k, n, 2) by each of `rays`."""
        return self.standing.shadows(self.rays)

    @cached_property
    def _blockers(self) -> Blockers:
        return Blockers.of(self.standing.solids)

    def _flood(self, points: Array, normals: Array, flood: Flood) -> Array:
        """Return a floodlight's share: on open floor its own, by the cosine law and the visible part of the lamp."""
        towards = direction(flood.azimuth_rad, flood.elevation_rad)
        cosine = np.clip(np.einsum("ij,j->i", normals, towards), 0.0, None)
        # floodlights are aimed at the floor: what stands upright gets less than a parallel beam would give it
        share: Array = flood.share * cosine / (towards[2] + UPRIGHT_LOSS * (1 - normals[:, 2]))
        facing = np.flatnonzero(share)
        share[facing] *= 1 - shadowed(points[facing], flood_rays(flood), self._blockers).mean(axis=0)
        return share

    def openness(self, points: Array) -> Array:
        """Return the share of diffuse light that reaches each point (n, 3): less in the tunnel and at its mouths."""
        openness = np.ones(len(points))
        if self._tunnel is None:
            return openness
        near = _within(points, self._tunnel_box)
        if len(near):
            low = points[near, 2] < self.scenario.arena_spec.tunnel_height_m
            openness[near] = np.where(low, self._low_openness(*self._on_road(points[near, :2])), 1.0)
        return openness

    def openness_on_floor(self, x: Array, y: Array) -> NDArray[np.float32]:
        """Return `openness` on the floor (h, w) at evenly spaced x (w,) and y (h,).

        Where on the road a texel is changes evenly, so that is computed for every fourth one each way.
        """
        openness = np.ones((len(y), len(x)), np.float32)
        if self._tunnel is None:
            return openness
        x0, y0, x1, y1 = self._tunnel_box
        columns, rows = np.flatnonzero((x > x0) & (x < x1)), np.flatnonzero((y > y0) & (y < y1))
        if len(columns) and len(rows):
            across, down = x[columns], y[rows]
            shape = -(-len(down) // ROAD_TEXELS) + 1, -(-len(across) // ROAD_TEXELS) + 1
            coarse = [np.linspace(at[0], at[-1], n) for at, n in ((across, shape[1]), (down, shape[0]))]
            places = np.stack(np.meshgrid(*coarse), axis=2).reshape(-1, 2)
            s, offset = (
                _between(of_road.reshape(shape), (len(down), len(across))) for of_road in self._on_road(places)
            )
            openness[np.ix_(rows, columns)] = self._low_openness(s, offset)
        return openness

    def _on_road(self, points: Array) -> tuple[Array, Array]:
        """Return where along the road points (n, 2) about the tunnel are, without a jump at the lap's end, and how far
        from its middle.
        """
        assert self._tunnel
        centre, s0, s1, _ = self._tunnel
        middle, half_lap = (s0 + s1) / 2, centre.length_m / 2
        s, offset = centre.project(points, around_s_m=middle, window_m=(s1 - s0) / 2 + MOUTH_M)
        through = (s - middle + half_lap) % centre.length_m + middle - half_lap
        return through, np.abs(offset)

    def _low_openness(self, s: Array, offset: Array) -> Array:
        """Return the openness lower than the tunnel's roof, at places of the road."""
        assert self._tunnel
        _, s0, s1, half = self._tunnel
        inside = (offset < half) & (s > s0) & (s < s1)
        daylight = 0.5 * (np.exp(-(s - s0) / TUNNEL_REACH_M) + np.exp(-(s1 - s) / TUNNEL_REACH_M))
        before = np.maximum(s0 - s, s - s1)
        lost = (0.5 - TUNNEL_FLOOR_SHARE) * np.exp(-before / MOUTH_REACH_M)
        lost *= np.exp(-np.maximum(offset - half, 0.0) / MOUTH_REACH_M)
        at_mouth = np.where((before > 0) & (before < MOUTH_M), 1.0 - lost, 1.0)
        openness: Array = np.where(inside, TUNNEL_FLOOR_SHARE + daylight, at_mouth)
        return openness

    @cached_property
    def _tunnel(self) -> tuple[Path, float, float, float] | None:
        """The road's middle, the stretch of it that the tunnel covers, half the tunnel's width."""
        tunnel, spec, course = self.scenario.tunnel, self.scenario.arena_spec, self.scenario.course
        if tunnel is None:
            return None
        s0, s1 = tunnel_s_on_centre(course, tunnel)
        return road_centre(course), s0, s1, spec.tunnel_clear_half_width_m + spec.tunnel_wall_m / 2

    @cached_property
    def _tunnel_box(self) -> tuple[float, float, float, float]:
        """x0, y0, x1, y1 around the tunnel."""
        assert self._tunnel
        centre, s0, s1, half = self._tunnel
        way = centre.poses(np.linspace(s0, s1, 24))[:, :2]
        reach = half + MOUTH_M
        (x0, y0), (x1, y1) = way.min(axis=0) - reach, way.max(axis=0) + reach
        return float(x0), float(y0), float(x1), float(y1)


def _between(coarse: Array, shape: tuple[int, int]) -> Array:
    """Return values (h, w) between those at the corners and evenly between them (rows, columns)."""
    (rows, columns), (height, width) = coarse.shape, shape
    scale_x, scale_y = ((few - 1) / max(many - 1, 1) for few, many in ((columns, width), (rows, height)))
    column, row = np.arange(width) * scale_x, np.arange(height) * scale_y
    left, top = np.minimum(column.astype(int), columns - 2), np.minimum(row.astype(int), rows - 2)
    right, low = column - left, (row - top)[:, None]
    upper, lower = coarse[top], coarse[top + 1]
    rows_between = upper + low * (lower - upper)
    between: Array = rows_between[:, left] + right * (rows_between[:, left + 1] - rows_between[:, left])
    return between


def _within(points: Array, box: tuple[float, float, float, float]) -> NDArray[np.intp]:
    x0, y0, x1, y1 = box
    x, y = points[:, 0], points[:, 1]
    return np.flatnonzero((x > x0) & (x < x1) & (y > y0) & (y < y1))


def direction(azimuth_rad: float, elevation_rad: float) -> Array:
    """Return the unit vector (3,) towards a far light."""
    level = math.cos(elevation_rad)
    return np.array([level * math.cos(azimuth_rad), level * math.sin(azimuth_rad), math.sin(elevation_rad)])


def flood_rays(flood: Flood) -> Array:
    """Return four directions (4, 3) towards a floodlight's face."""
    half = PENUMBRA_RAD / 2
    return np.array([direction(flood.azimuth_rad + da * half, flood.elevation_rad + de * half) for da, de in CORNERS])


def sky(normals: Array) -> Array:
    """Return the share of an even sky above a floor that gives back a fifth: 1 facing up, 0.2 facing down."""
    share: Array = 0.6 + 0.4 * normals[:, 2]
    return share


def lamp(points: Floats, normals: Floats, place: Floats) -> Floats:
    """Return one lamp's part of the lamps' share, which is about 1 on average on the floor.

    By the inverse square and both cosines.
    """
    to_lamp = place - points
    square = np.einsum("ij,ij->i", to_lamp, to_lamp) + LAMP_SOFT_M2
    cosines = np.clip(np.einsum("ij,ij->i", to_lamp, normals), 0.0, None) * np.clip(to_lamp[:, 2], 0.0, None)
    share: Floats = cosines / (square * square) * LAMP_GAIN_M2
    return share


def lamp_on_floor(x: Array, y: Array, place: Array) -> NDArray[np.float32]:
    """Return `lamp` on the open floor (h, w) at x (w,) and y (h,), in a tenth of the time."""
    return lamp_share_at(x, y[:, None], place)


def lamp_share_at(x: Array, y: Array, place: Array) -> NDArray[np.float32]:
    """Return `lamp` on the open floor at x and y of any shapes that go together."""
    lx, ly, lz = place
    across, along = ((x - lx) ** 2).astype(np.float32), ((y - ly) ** 2 + lz**2 + LAMP_SOFT_M2).astype(np.float32)
    square = along + across
    return np.asarray(np.float32(lz**2 * LAMP_GAIN_M2) / (square * square), np.float32)


def white_of(kelvin: float) -> Array:
    """Return linear rgb of a black body with green = 1; cameras take a part of it out again (white balance).

    A rough fit to the black-body locus in linear sRGB from 2,500 K to 8,000 K (within a fifth).
    """
    x = math.log(kelvin / 6600.0)
    white: Array = np.array([math.exp(-1.05 * x), 1.0, math.exp(1.35 * x)])
    return white
