"""The floor's light: a picture baked once, and baked anew around bodies that have moved.

Each texel knows, ray by ray, which lights see it: 32 rays, four to each of two floodlights and six lamps. What stands
for good and each body contribute their own shadows, so a body's can be taken out again without a trace.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.render.light import CORNERS, LAMP_SIZE_M, Lighting, flood_rays, lamp_on_floor
from adc_bench.render.shadows import outline_points, shadow_points
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]
Bounds = tuple[float, float, float, float]
Window = tuple[int, int, int, int]  # rows and columns: r0, r1, c0, c1
SUBTEXEL_BITS = 4
CONTACT_SHADE, CONTACT_GAP_M = 0.6, 0.2  # darkening under a thing on the floor, and how fast it goes with a gap
CONTACT_REACH, CONTACT_REACH_M = 0.2, 0.09  # e-folding reach: of the thing's height, and at most


@dataclass(frozen=True, kw_only=True, eq=False)
class Shade:
    """What a body takes from the texels from (row, column) on: blocked rays (h, w) and the open part of the sky."""

    row: int
    column: int
    blocked: NDArray[np.uint32]
    open_sky: NDArray[np.float32]

    @property
    def window(self) -> Window:
        """Rows and columns (r0, r1, c0, c1)."""
        height, width = self.blocked.shape
        return self.row, self.row + height, self.column, self.column + width


class FloorLight:
    """The light on a rectangle of floor.

    Attributes:
        picture: (h, w, 4) float32: irradiance rgb in units of 300 lux, and the floodlights' share of it.
    """

    def __init__(self, lighting: Lighting, bounds: Bounds, texel_m: float, unseen: Bounds | None = None) -> None:
        """Bake the light of what stands for good. Under `unseen` lies another floor: bodies are not baked there."""
        self.bounds, self._lighting = bounds, lighting
        x0, y0, x1, y1 = bounds
        width, height = round((x1 - x0) / texel_m), round((y1 - y0) / texel_m)
        self._scale = np.array([width / (x1 - x0), -height / (y1 - y0)])
        self._origin = np.array([x0, y1])
        self._unseen = self._inner_window(unseen) if unseen else (0, 0, 0, 0)
        x = x0 + (np.arange(width) + 0.5) / width * (x1 - x0)
        y = y1 - (np.arange(height) + 0.5) / height * (y1 - y0)
        self._lights, self._parts = _rays(lighting), _contributions(lighting, x, y)
        points = np.column_stack([np.tile(x, height), np.repeat(y, width), np.zeros(height * width)])
        openness = lighting.openness(points).reshape(height, width).astype(np.float32)
        self._parts[len(lighting.scenario.look.floods) :] *= openness
        self._sky = np.float32(lighting.sky_share) * openness
        self._blocked = np.zeros((height, width), np.uint32)
        self._shades: dict[str, Shade] = {}
        self._bake_static(lighting.scenario.solids)
        self.picture = np.empty((height, width, 4), np.float32)
        self._bake((0, height, 0, width))

    def place(self, bodies: Mapping[str, tuple[Sequence[Solid], Pose3]]) -> bool:
        """Put bodies (parts in their own frame, pose in the world) where they are now, and bake the light there.

        Returns whether the picture has changed.
        """
        baked = False
        for name, (parts, pose) in bodies.items():
            before, after = self._shades.pop(name, None), self._shade(parts, pose)
            self._shades[name] = after
            windows = [shade.window for shade in (before, after) if shade]
            for window in _joined(windows):
                baked |= self._bake(window)
        return baked

    def at(self, points_world: Array) -> Array:
        """Return the irradiance (n, 3) at floor points (n, 2), those beyond the border as on it."""
        texels = (points_world - self._origin) * self._scale
        height, width = self._sky.shape
        column = np.clip(texels[:, 0], 0, width - 1).astype(int)
        row = np.clip(texels[:, 1], 0, height - 1).astype(int)
        return np.asarray(self.picture[row, column, :3], np.float64)

    def _inner_window(self, bounds: Bounds) -> Window:
        """Return the rows and columns well inside bounds: the texels beyond are seen, or mixed with what is seen."""
        x0, y0, x1, y1 = bounds
        (c0, r0), (c1, r1) = ((np.array(corner) - self._origin) * self._scale for corner in ((x0, y1), (x1, y0)))
        return math.ceil(r0) + 1, math.floor(r1) - 1, math.ceil(c0) + 1, math.floor(c1) - 1

    def _outlines(self, points: Array) -> list[NDArray[np.int32]]:
        """Return hulls (m, 1, 2) of point sets (k, n, 2), in 1/16 texels for cv2: pixel centres at whole numbers."""
        texels = (points - self._origin) * self._scale - 0.5
        return [np.asarray(cv2.convexHull(p)) for p in np.rint(texels * 2**SUBTEXEL_BITS).astype(np.int32)]

    def _bake_static(self, solids: Iterable[Solid]) -> None:
        solids = [solid for solid in solids if solid.kind not in ("wall", "poster")]
        floods = len(CORNERS) * len(self._lighting.scenario.look.floods)
        outlines = []
        for solid in solids:
            # what the tunnel takes from the lamps is in the openness
            lights = self._lights[:floods] if solid.kind == "tunnel" else self._lights
            outlines.append(self._outlines(shadow_points(outline_points(solid), lights)))
        for ray in range(len(self._lights)):
            mask = np.zeros(self._sky.shape, np.uint8)
            for of_solid in outlines:
                if ray < len(of_solid):
                    cv2.fillConvexPoly(mask, of_solid[ray], 1, shift=SUBTEXEL_BITS)
            self._blocked |= mask.astype(np.uint32) << np.uint32(ray)
        for solid in solids:
            shade = self._shade([solid], None, lights=self._lights[:0])
            here, there = self._overlap(shade.window, (0, self._sky.shape[0], 0, self._sky.shape[1]), shade)
            self._sky[here] *= shade.open_sky[there]

    def _shade(self, parts: Sequence[Solid], pose: Pose3 | None, lights: Array | None = None) -> Shade:
        """Return what a body takes where it stands (its parts' frame is the world without a pose)."""
        lights = self._lights if lights is None else lights
        points = [outline_points(part, pose) for part in parts]
        reach_m = 4 * max(_contact_reach_m(p) for p in points)
        outlines = [self._outlines(shadow_points(p, lights)) for p in points]
        feet = [self._outlines(p[None, :, :2])[0] for p in points]
        every = np.concatenate([*feet, *(o for of_part in outlines for o in of_part)])[:, 0] >> SUBTEXEL_BITS
        margin = int(reach_m * self._scale[0]) + 2
        (c0, r0), (c1, r1) = every.min(axis=0) - margin, every.max(axis=0) + margin + 1
        shift = np.array([c0, r0], np.int32) << SUBTEXEL_BITS
        blocked, open_sky = np.zeros((r1 - r0, c1 - c0), np.uint32), np.ones((r1 - r0, c1 - c0), np.float32)
        for ray in range(len(lights)):
            mask = np.zeros(blocked.shape, np.uint8)
            for of_part in outlines:
                cv2.fillConvexPoly(mask, of_part[ray] - shift, 1, shift=SUBTEXEL_BITS)
            blocked |= mask.astype(np.uint32) << np.uint32(ray)
        for foot, p in zip(feet, points, strict=True):
            open_sky *= self._contact(foot - shift, open_sky.shape, p)
        return Shade(row=int(r0), column=int(c0), blocked=blocked, open_sky=open_sky)

    def _contact(self, foot: NDArray[np.int32], shape: tuple[int, ...], points: Array) -> NDArray[np.float32]:
        """Return the part of the sky (h, w) seen from the floor beside and under one part."""
        away = np.ones(shape, np.uint8)
        cv2.fillConvexPoly(away, foot, 0, shift=SUBTEXEL_BITS)
        distance = cv2.distanceTransform(away, cv2.DIST_L2, 5) / np.float32(self._scale[0] * _contact_reach_m(points))
        depth = CONTACT_SHADE * np.exp(-points[:, 2].min() / CONTACT_GAP_M)
        shade = np.float32(depth) * np.clip(np.exp(-distance) - np.float32(np.exp(-4.0)), 0, None)
        return np.asarray(1 - shade, np.float32)

    def _overlap(self, window: Window, other: Window, shade: Shade) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
        """Return where two windows meet: in the picture, and in the shade."""
        r0, r1 = max(window[0], other[0]), max(min(window[1], other[1]), max(window[0], other[0]))
        c0, c1 = max(window[2], other[2]), max(min(window[3], other[3]), max(window[2], other[2]))
        there = np.s_[r0 - shade.row : r1 - shade.row, c0 - shade.column : c1 - shade.column]
        return np.s_[r0:r1, c0:c1], there

    def _bake(self, window: Window) -> bool:
        """Bake the light of a window: the same sums in the same order whatever its size, so that bytes are equal.

        Returns whether any of it lies in the picture and out of the part that is never seen.
        """
        height, width = self._sky.shape
        r0, r1 = max(window[0], 0), min(window[1], height)
        c0, c1 = max(window[2], 0), min(window[3], width)
        if r0 >= r1 or c0 >= c1 or _contains(self._unseen, window):
            return False
        here = np.s_[r0:r1, c0:c1]
        blocked, diffuse = self._blocked[here].copy(), self._sky[here].copy()
        for name in sorted(self._shades):
            shade = self._shades[name]
            inside, there = self._overlap((r0, r1, c0, c1), shade.window, shade)
            local = (slice(inside[0].start - r0, inside[0].stop - r0), slice(inside[1].start - c0, inside[1].stop - c0))
            blocked[local] |= shade.blocked[there]
            diffuse[local] *= shade.open_sky[there]
        floods = np.zeros(diffuse.shape, np.float32)
        count = len(self._lighting.scenario.look.floods)
        for light, part in enumerate(self._parts):
            bits = (blocked >> np.uint32(light * len(CORNERS))) & np.uint32(15)
            (floods if light < count else diffuse)[...] += part[here] * _SEEN[bits]
        lighting, picture = self._lighting, self.picture[here]
        for channel in range(3):
            warm, cold = np.float32(lighting.warm[channel]), np.float32(lighting.cold[channel])
            picture[..., channel] = np.float32(lighting.level) * (diffuse * warm + floods * cold)
        picture[..., 3] = floods / np.maximum(diffuse + floods, np.float32(1e-6))
        return True


def _contains(outer: Window, inner: Window) -> bool:
    return outer[0] <= inner[0] and inner[1] <= outer[1] and outer[2] <= inner[2] and inner[3] <= outer[3]


def _joined(windows: Sequence[Window]) -> Sequence[Window]:
    """Return one window around two where that is less to bake."""
    r0, c0 = (min(window[k] for window in windows) for k in (0, 2))
    r1, c1 = (max(window[k] for window in windows) for k in (1, 3))
    around = (r0, r1, c0, c1)
    return [around] if _area(around) <= sum(map(_area, windows)) else windows


def _area(window: Window) -> int:
    return (window[1] - window[0]) * (window[3] - window[2])


_SEEN = np.array([1 - bits.bit_count() / 4 for bits in range(16)], np.float32)


def _contact_reach_m(points: Array) -> float:
    return min(CONTACT_REACH_M, 0.02 + CONTACT_REACH * float(np.ptp(points[:, 2])))


def _rays(lighting: Lighting) -> Array:
    """Return the lights' rays (k, 4) for `shadow_outlines`: four to each floodlight, then four to each lamp."""
    floods = [(*ray, 0.0) for flood in lighting.scenario.look.floods for ray in flood_rays(flood)]
    half = LAMP_SIZE_M / 2
    lamps = [(x + dx * half, y + dy * half, z, 1.0) for x, y, z in lighting.lamps for dx, dy in CORNERS]
    return np.array([*floods, *lamps])


def _contributions(lighting: Lighting, x: Array, y: Array) -> NDArray[np.float32]:
    """Return what each light gives to open floor (lights, h, w) at x (w,) and y (h,)."""
    shape = len(y), len(x)
    floods = [np.full(shape, flood.share, np.float32) for flood in lighting.scenario.look.floods]
    lamps = [np.float32(lighting.lamp_share) * lamp_on_floor(x, y, place) for place in lighting.lamps]
    return np.array([*floods, *lamps], np.float32)
