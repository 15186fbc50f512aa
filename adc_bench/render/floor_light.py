"""The floor's light: a picture baked once, and baked anew around bodies that have moved.

Each texel knows, ray by ray, which lights see it: 32 rays, four to each of two floodlights and six lamps. What stands
for good and each body contribute their own shadows, so a body's can be taken out again without a trace.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.render.light import LAMP_GRID, Lighting, lamp_on_floor
from adc_bench.render.shadows import Outlines
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]
Bounds = tuple[float, float, float, float]
Window = tuple[int, int, int, int]  # rows and columns: r0, r1, c0, c1
Placed = Mapping[str, tuple[Sequence[Solid], Pose3]]  # bodies: parts in their own frame, pose in the world
NONE: Window = (0, 0, 0, 0)
EMPTY: Placed = MappingProxyType({})
SUBTEXEL_BITS = 4
CONTACT_SHADE, CONTACT_GAP_M = 0.6, 0.2  # darkening under a thing on the floor, and how fast it goes with a gap
CONTACT_TOP_M = 1.2  # what hangs higher darkens the floor by less than half a step of 255
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

    def __init__(
        self,
        lighting: Lighting,
        bounds: Bounds,
        texel_m: float,
        unseen: Bounds | None = None,
        bodies: Placed = EMPTY,
    ) -> None:
        """Bake the light of what stands for good, and of bodies. Under `unseen` lies another floor: nothing is baked
        there.
        """
        self.bounds, self._lighting = bounds, lighting
        x0, y0, x1, y1 = bounds
        width, height = round((x1 - x0) / texel_m), round((y1 - y0) / texel_m)
        self._scale = np.array([width / (x1 - x0), -height / (y1 - y0)])
        self._origin = np.array([x0, y1])
        self._unseen = self._inner_window(unseen) if unseen else NONE
        x = x0 + (np.arange(width) + 0.5) / width * (x1 - x0)
        y = y1 - (np.arange(height) + 0.5) / height * (y1 - y0)
        self._lights, self._parts = lighting.rays, _contributions(lighting, x, y)
        openness = lighting.openness_on_floor(x, y)
        self._parts[len(lighting.scenario.look.floods) :] *= openness
        self._sky = np.float32(lighting.sky_share) * openness
        self._bake_static(lighting.standing)
        self._shades = {name: self._shade(parts, pose) for name, (parts, pose) in bodies.items()}
        self.picture = np.empty((height, width, 4), np.float32)
        self._bake((0, height, 0, width))

    def place(self, bodies: Placed) -> bool:
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

    def _texels(self, points: Array) -> NDArray[np.int32]:
        """Return points (..., 2) in 1/16 texels for cv2: pixel centres at whole numbers."""
        texels = (points - self._origin) * self._scale - 0.5
        return np.asarray(np.rint(texels * 2**SUBTEXEL_BITS), np.int32)

    def _bake_static(self, standing: Outlines) -> None:
        in_the_way = self._lighting.casts(standing)
        texels = self._texels(self._lighting.standing_shadows)
        in_the_way &= ~self._hidden(standing.lowest(texels), standing.highest(texels))
        self._blocked = _blocked(texels, standing, self._sky.shape, in_the_way)
        feet = standing.each(self._texels(standing.points[:, :2]))
        for foot, (bottom_m, top_m) in zip(feet, standing.heights_m, strict=True):
            if bottom_m < CONTACT_TOP_M:
                self._touch(self._sky, foot, bottom_m, top_m, self._unseen)

    def _shade(self, parts: Sequence[Solid], pose: Pose3) -> Shade:
        """Return what a body takes where it stands."""
        outlines = Outlines.of(parts, pose)
        texels, feet = self._texels(outlines.shadows(self._lights)), self._texels(outlines.points[:, :2])
        margin = max(self._margin(_contact_reach_m(*heights)) for heights in outlines.heights_m)
        window, origin = _around(np.concatenate([feet, texels.reshape(-1, 2)]), margin)
        r0, r1, c0, c1 = window
        shape = r1 - r0, c1 - c0
        if not self._shows(window):
            nothing = np.broadcast_to(np.uint32(0), shape), np.broadcast_to(np.float32(1), shape)
            return Shade(row=r0, column=c0, blocked=nothing[0], open_sky=nothing[1])
        open_sky = np.ones(shape, np.float32)
        for foot, (bottom_m, top_m) in zip(outlines.each(feet - origin), outlines.heights_m, strict=True):
            self._touch(open_sky, foot, bottom_m, top_m)
        blocked = _blocked(texels - origin, outlines, shape, self._lighting.casts(outlines))
        return Shade(row=r0, column=c0, blocked=blocked, open_sky=open_sky)

    def _margin(self, reach_m: float) -> int:
        """Return how many texels around a thing its contact shade of this e-folding reach goes."""
        return int(4 * reach_m * self._scale[0]) + 2

    def _touch(
        self, sky: NDArray[np.float32], foot: NDArray[np.int32], bottom_m: float, top_m: float, unseen: Window = NONE
    ) -> None:
        """Darken a picture of the open sky (h, w) beside and under one part, its foot in that picture's 1/16 texels."""
        reach_m = _contact_reach_m(bottom_m, top_m)
        (height, width), (window, origin) = sky.shape, _around(foot, self._margin(reach_m))
        r0, r1, c0, c1 = window
        if r0 < height and r1 > 0 and c0 < width and c1 > 0 and not _contains(unseen, window):
            shade = self._contact(foot - origin, (r1 - r0, c1 - c0), bottom_m, reach_m)
            here = np.s_[max(r0, 0) : min(r1, height), max(c0, 0) : min(c1, width)]
            sky[here] *= shade[max(-r0, 0) : min(r1, height) - r0, max(-c0, 0) : min(c1, width) - c0]

    def _hidden(self, low: NDArray[np.int32], high: NDArray[np.int32]) -> NDArray[np.bool_]:
        """Return whether boxes of 1/16 texels (..., 2) lie in the part that is never seen."""
        r0, r1, c0, c1 = self._unseen
        first, last = (np.array(corner) << SUBTEXEL_BITS for corner in ((c0, r0), (c1 - 1, r1 - 1)))
        return np.asarray(((low >= first) & (high <= last)).all(axis=-1))

    def _shows(self, window: Window) -> bool:
        """Return whether any of a window lies in the picture and out of the part that is never seen."""
        (r0, r1, c0, c1), (height, width) = window, self._sky.shape
        return r0 < height and r1 > 0 and c0 < width and c1 > 0 and not _contains(self._unseen, window)

    def _contact(
        self, foot: NDArray[np.int32], shape: tuple[int, int], bottom_m: float, reach_m: float
    ) -> NDArray[np.float32]:
        """Return the part of the sky (h, w) seen from the floor beside and under one part."""
        away = np.ones(shape, np.uint8)
        cv2.fillConvexPoly(away, cv2.convexHull(foot), 0, shift=SUBTEXEL_BITS)
        distance = cv2.distanceTransform(away, cv2.DIST_L2, 5)
        near = np.asarray(cv2.exp(distance * np.float32(-1 / (self._scale[0] * reach_m))), np.float32)
        depth = CONTACT_SHADE * math.exp(-bottom_m / CONTACT_GAP_M)
        return np.asarray(1 - np.float32(depth) * np.maximum(near - np.float32(math.exp(-4.0)), 0), np.float32)

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
        if not self._shows(window):
            return False
        height, width = self._sky.shape
        r0, r1 = max(window[0], 0), min(window[1], height)
        c0, c1 = max(window[2], 0), min(window[3], width)
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
            pair, half = divmod(light, 2)
            rays = cv2.extractChannel(blocked.view(np.uint8).reshape(*diffuse.shape, 4), pair)
            (floods if light < count else diffuse)[...] += part[here] * cv2.LUT(rays, _SEEN[half])
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


# the share of a light that a byte of two lights' blocked rays leaves: of the first light, and of the second
_SEEN = np.array([[1 - (byte >> by & 15).bit_count() / 4 for byte in range(256)] for by in (0, 4)], np.float32)


def _blocked(
    texels: NDArray[np.int32], outlines: Outlines, shape: tuple[int, ...], casts: NDArray[np.bool_] | None = None
) -> NDArray[np.uint32]:
    """Return which rays are blocked (h, w), a bit each, by shadows whose hulls' points (k, n, 2) are in 1/16 texels.

    `casts` (k, solids) says whether a solid stands in a ray's way at all.
    """
    height, width = shape
    seen = (outlines.highest(texels) >= 0) & (outlines.lowest(texels) <= np.array([width, height]) << SUBTEXEL_BITS)
    meets = np.asarray(seen.all(axis=2) if casts is None else seen.all(axis=2) & casts)
    planes = [np.zeros((height, width), np.uint8) for _ in range(4)]
    for ray, of_ray in enumerate(texels):
        mask = np.zeros((height, width), np.uint8)
        for solid in np.flatnonzero(meets[ray]).tolist():
            hull = cv2.convexHull(of_ray[outlines.starts[solid] : outlines.starts[solid + 1]])
            cv2.fillConvexPoly(mask, hull, 1 << ray % 8, shift=SUBTEXEL_BITS)
        cv2.bitwise_or(planes[ray // 8], mask, planes[ray // 8])
    return np.asarray(cv2.merge(planes)).view("<u4")[..., 0]


def _around(texels: NDArray[np.int32], margin: int) -> tuple[Window, NDArray[np.int32]]:
    """Return the window around points (n, 2) in 1/16 texels, and where it begins in 1/16 texels."""
    x, y, width, height = cv2.boundingRect(texels)
    c0, r0 = ((low >> SUBTEXEL_BITS) - margin for low in (x, y))
    c1, r1 = ((high - 1 >> SUBTEXEL_BITS) + margin + 1 for high in (x + width, y + height))
    return (r0, r1, c0, c1), np.array([c0, r0], np.int32) << SUBTEXEL_BITS


def _contact_reach_m(bottom_m: float, top_m: float) -> float:
    return min(CONTACT_REACH_M, 0.02 + CONTACT_REACH * (top_m - bottom_m))


def _contributions(lighting: Lighting, x: Array, y: Array) -> NDArray[np.float32]:
    """Return what each light gives to open floor (lights, h, w) at x (w,) and y (h,)."""
    floods, lamps = lighting.scenario.look.floods, _lamps_on_floor(x.tobytes(), y.tobytes(), lighting.lamp_height_m)
    parts = np.empty((len(floods) + len(lamps), len(y), len(x)), np.float32)
    for part, flood in zip(parts, floods, strict=False):
        part.fill(flood.share)
    np.multiply(lamps, np.float32(lighting.lamp_share), out=parts[len(floods) :])
    return parts


@lru_cache(maxsize=4)
def _lamps_on_floor(x: bytes, y: bytes, height_m: float) -> NDArray[np.float32]:
    """Return each lamp's part of the lamps' share (lamps, h, w): the same in every arena of a size."""
    places = [np.array([*place, height_m]) for place in LAMP_GRID]
    lamps = np.array([lamp_on_floor(np.frombuffer(x), np.frombuffer(y), place) for place in places], np.float32)
    lamps.setflags(write=False)
    return lamps
