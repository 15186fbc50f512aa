"""Procedural surfaces in two tones: red = tone of the surface's own colour, green = share of its second colour.

The floor's second colour is the paint of the lines, rasterised from the course's polygons; it has two channels more:
blue = where the paint wears off, alpha = where dust and scuffs lie.
"""

import math
from collections.abc import Mapping
from functools import lru_cache

import cv2
import msgspec
import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.streams import stream

Rgb = tuple[float, float, float]
TwoTone = NDArray[np.uint8]
Bounds = tuple[float, float, float, float]
METRES_PER_TEXEL_COURSE = 0.005
PAINT_SAMPLES = 4  # along each side of a texel
PAINT_MARGIN_M, FLOOR_GRID_M = 0.2, 0.05  # the grid: whole texels of paint and of light
METRES_PER_TEXEL_HALL = 0.02
METRES_PER_TEXEL_FIELD = 0.04  # of what varies slowly over the hall's floor
FIELD_REACH_M = (12.0, 8.0)
FIELD_SHAPE = (
    round(2 * FIELD_REACH_M[1] / METRES_PER_TEXEL_FIELD),
    round(2 * FIELD_REACH_M[0] / METRES_PER_TEXEL_FIELD),
)
STREAK_M = 1.3  # length of the streaks that wheels leave on a covering


class FloorKind(msgspec.Struct, frozen=True, kw_only=True):
    """A floor covering: albedo and how strongly it varies (standard deviations relative to the albedo)."""

    albedo: Rgb
    grain: float  # from texel to texel
    blotch: float  # over decimetres
    streak: float  # along x, as of wheels
    speckle: float  # share of bright specks


FLOOR_KINDS: Mapping[str, FloorKind] = {
    "black_carpet": FloorKind(albedo=(0.045, 0.045, 0.048), grain=0.35, blotch=0.10, streak=0.00, speckle=0.0),
    "grey_carpet": FloorKind(albedo=(0.110, 0.110, 0.115), grain=0.25, blotch=0.10, streak=0.05, speckle=0.0),
    "charcoal_vinyl": FloorKind(albedo=(0.065, 0.066, 0.070), grain=0.06, blotch=0.18, streak=0.12, speckle=0.0),
    "worn_vinyl": FloorKind(albedo=(0.090, 0.086, 0.080), grain=0.08, blotch=0.28, streak=0.20, speckle=0.002),
    "rubber_mat": FloorKind(albedo=(0.035, 0.036, 0.036), grain=0.15, blotch=0.06, streak=0.08, speckle=0.0),
    "speckled_rubber": FloorKind(albedo=(0.055, 0.055, 0.060), grain=0.12, blotch=0.08, streak=0.03, speckle=0.012),
    "felt": FloorKind(albedo=(0.070, 0.068, 0.066), grain=0.30, blotch=0.16, streak=0.00, speckle=0.0),
    "painted_board": FloorKind(albedo=(0.050, 0.052, 0.058), grain=0.05, blotch=0.14, streak=0.24, speckle=0.001),
    "scuffed_linoleum": FloorKind(albedo=(0.095, 0.095, 0.090), grain=0.07, blotch=0.22, streak=0.16, speckle=0.004),
}


class WallKind(msgspec.Struct, frozen=True, kw_only=True):
    """A wall: its albedo, a second one, and where the second one shows."""

    albedo: Rgb
    second: Rgb
    joint_x_m: float = 0.0  # upright joints every so far (0: none)
    joint_z_m: float = 0.0  # level joints every so far (0: none)
    joint_width_m: float = 0.04
    staggered: bool = False
    rectangles: int = 0  # posters, cabinets, windows: so many rectangles
    fold_m: float = 0.0  # wave length of the folds of a curtain (0: none)
    band_m: float = 0.0  # height of a band at the bottom (0: none)


WALL_KINDS: Mapping[str, WallKind] = {
    "plaster": WallKind(albedo=(0.70, 0.68, 0.62), second=(0.35, 0.34, 0.32), band_m=0.9),
    "brick": WallKind(
        albedo=(0.38, 0.18, 0.13), second=(0.55, 0.52, 0.48), joint_x_m=0.5, joint_z_m=0.24, staggered=True
    ),
    "panels": WallKind(albedo=(0.48, 0.36, 0.22), second=(0.14, 0.10, 0.06), joint_x_m=1.2, joint_z_m=1.3),
    "banners": WallKind(albedo=(0.68, 0.66, 0.60), second=(0.42, 0.12, 0.10), joint_z_m=0.55, joint_width_m=0.2),
    "slats": WallKind(albedo=(0.55, 0.46, 0.34), second=(0.12, 0.10, 0.08), joint_x_m=0.45, joint_width_m=0.16),
    "ladder_bars": WallKind(
        albedo=(0.20, 0.22, 0.24), second=(0.70, 0.62, 0.48), joint_x_m=1.1, joint_z_m=0.3, joint_width_m=0.08
    ),
    "stripes": WallKind(albedo=(0.66, 0.70, 0.72), second=(0.10, 0.22, 0.45), joint_z_m=0.8, joint_width_m=0.3),
    "concrete": WallKind(albedo=(0.42, 0.42, 0.41), second=(0.28, 0.28, 0.28), joint_x_m=2.4, joint_z_m=1.0),
    "posters": WallKind(albedo=(0.75, 0.74, 0.70), second=(0.50, 0.10, 0.10), rectangles=18),
    "curtain": WallKind(albedo=(0.30, 0.10, 0.12), second=(0.08, 0.03, 0.04), fold_m=0.35),
    "shelves": WallKind(
        albedo=(0.60, 0.56, 0.48), second=(0.15, 0.30, 0.25), joint_x_m=0.9, joint_z_m=0.5, rectangles=10
    ),
    "blocks": WallKind(albedo=(0.62, 0.66, 0.60), second=(0.20, 0.45, 0.60), band_m=0.5, rectangles=9),
}


@lru_cache(maxsize=2)
def _paint(spec: CourseSpec) -> tuple[shapely.Polygon, ...]:
    return Course(spec=spec).paint


@lru_cache(maxsize=2)
def course_bounds(spec: CourseSpec) -> tuple[float, float, float, float]:
    """Return x0, y0, x1, y1 in metres of the floor that carries paint, with a margin, on the texels' grid."""
    x0, y0, x1, y1 = shapely.total_bounds(_paint(spec))
    low = [math.floor((side - PAINT_MARGIN_M) / FLOOR_GRID_M) * FLOOR_GRID_M for side in (x0, y0)]
    high = [math.ceil((side + PAINT_MARGIN_M) / FLOOR_GRID_M) * FLOOR_GRID_M for side in (x1, y1)]
    return low[0], low[1], high[0], high[1]


@lru_cache(maxsize=2)
def paint_mask(spec: CourseSpec) -> NDArray[np.uint8]:
    """Return the paint's coverage (h, w) uint8 over `course_bounds`; row 0 is the largest y."""
    x0, y0, x1, y1 = course_bounds(spec)
    width, height = round((x1 - x0) / METRES_PER_TEXEL_COURSE), round((y1 - y0) / METRES_PER_TEXEL_COURSE)
    fine_m = METRES_PER_TEXEL_COURSE / PAINT_SAMPLES
    fine = np.zeros((height * PAINT_SAMPLES, width * PAINT_SAMPLES), np.uint8)
    for polygon in _paint(spec):
        shrunk = polygon.buffer(-fine_m / 2, join_style="mitre")  # cv2 also fills the pixels that an outline crosses
        rings = (shrunk.exterior, *shrunk.interiors)
        contours = [_samples(shapely.get_coordinates(ring), x0, y1, fine_m) for ring in rings]
        cv2.fillPoly(fine, contours, 255, cv2.LINE_8, shift=6)
    mask = np.asarray(cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA), np.uint8)
    mask.setflags(write=False)
    return mask


def _samples(points: NDArray[np.float64], x0: float, y1: float, fine_m: float) -> NDArray[np.int32]:
    """Return 1/64 samples for cv2, whose pixel centres are at whole numbers."""
    samples = np.stack([points[:, 0] - x0, y1 - points[:, 1]], axis=1) / fine_m - 0.5
    return np.round(samples * 64).astype(np.int32)


def floor_texture(kind: FloorKind, seed: int, spec: CourseSpec) -> TwoTone:
    """Return the painted part of the floor, (h, w, 4)."""
    mask, bounds = paint_mask(spec), course_bounds(spec)
    tone = _floor_tone(kind, seed, mask.shape, bounds, stream(seed, "grain"))
    wear = _wear(mask.shape, METRES_PER_TEXEL_COURSE, stream(seed, "wear"))
    dust = _dust(mask.shape, bounds, seed)
    return np.asarray(cv2.merge([tone, mask, wear, dust]), np.uint8)


def hall_texture(kind: FloorKind, seed: int, length_m: float, width_m: float) -> TwoTone:
    """Return the bare floor of the whole hall, (h, w, 4)."""
    shape = (round(width_m / METRES_PER_TEXEL_HALL), round(length_m / METRES_PER_TEXEL_HALL))
    bounds = (-length_m / 2, -width_m / 2, length_m / 2, width_m / 2)
    tone = _floor_tone(kind, seed, shape, bounds, stream(seed, "hall"))
    none, dust = np.zeros(shape, np.uint8), _dust(shape, bounds, seed)
    return np.asarray(cv2.merge([tone, none, none, dust]), np.uint8)


def _wear(shape: tuple[int, ...], metres_per_texel: float, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return where paint wears off: patches, and tyre marks across and along the road."""
    coarse = _coarse(shape)
    texel = metres_per_texel * COARSE
    worn = 0.3 + 0.4 * _blotches(coarse, 0.12, texel, rng) + 0.3 * _blotches(coarse, 0.9, texel, rng)
    marks = np.zeros(coarse, np.uint8)
    _draw_strokes(marks, 60, (0.6, 2.5), 0.035 / texel, texel, rng)
    worn += 0.7 * cv2.GaussianBlur(marks, (0, 0), 1.0).astype(np.float32) / 255
    return _refined(255 * np.clip(worn, 0, 1), shape)


def _dust(shape: tuple[int, ...], bounds: Bounds, seed: int) -> NDArray[np.uint8]:
    """Return where dust and light scuffs lie within bounds."""
    return _part_of(_dust_field(seed), shape, bounds)


def _part_of(field: NDArray[np.uint8], shape: tuple[int, ...], bounds: Bounds) -> NDArray[np.uint8]:
    """Return the part within bounds, as fine as `shape`, of a field over the whole hall: no seam between floors."""
    (reach_x, reach_y), (x0, _, x1, y1) = FIELD_REACH_M, bounds
    per_texel = (x1 - x0) / shape[1] / METRES_PER_TEXEL_FIELD
    left, top = (x0 + reach_x) / METRES_PER_TEXEL_FIELD, (reach_y - y1) / METRES_PER_TEXEL_FIELD
    middle = 0.5 * per_texel - 0.5  # of the first texel, in the field's
    place = np.array([[per_texel, 0, left + middle], [0, per_texel, top + middle]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(field, place, (shape[1], shape[0]), flags=flags), np.uint8)


@lru_cache(maxsize=2)
def _dust_field(seed: int) -> NDArray[np.uint8]:
    """Return dust over the hall and some more: faint clouds, and strokes of shoes and wheels."""
    rng, texel = stream(seed, "dust"), METRES_PER_TEXEL_FIELD
    dust = 0.10 + 0.06 * _blotches(FIELD_SHAPE, 0.5, texel, rng) + 0.05 * _blotches(FIELD_SHAPE, 2.0, texel, rng)
    scuffs = np.zeros(FIELD_SHAPE, np.uint8)
    _draw_strokes(scuffs, 300, (0.05, 0.6), 1.0, texel, rng)
    dust += 0.30 * cv2.GaussianBlur(scuffs, (0, 0), 0.6).astype(np.float32) / 255
    return np.asarray(np.clip(255 * dust, 0, 255), np.uint8)


@lru_cache(maxsize=2)
def _tone_field(kind: FloorKind, seed: int) -> NDArray[np.uint8]:
    """Return what varies slowly of a covering's tone over the hall and some more, 128 being the albedo itself."""
    rng, texel, (rows, columns) = stream(seed, "floor"), METRES_PER_TEXEL_FIELD, FIELD_SHAPE
    tone = 1 + kind.blotch * _blotches(FIELD_SHAPE, 0.3, texel, rng)
    streaks = rng.standard_normal((rows, round(columns * texel / STREAK_M))).astype(np.float32)
    tone += kind.streak * cv2.resize(streaks, (columns, rows))
    return np.asarray(np.clip(128 * tone, 0, 255), np.uint8)


def _draw_strokes(
    picture: NDArray[np.uint8],
    count: int,
    length_m: tuple[float, float],
    width_px: float,
    metres_per_px: float,
    rng: np.random.Generator,
) -> None:
    """Draw bent strokes of random strength."""
    height, width = picture.shape
    t = np.linspace(0, 1, 9)
    for _ in range(count):
        start, heading = rng.uniform((0, 0), (width, height)), rng.uniform(0, 2 * np.pi)
        length, bend = rng.uniform(*length_m) / metres_per_px, rng.uniform(-1.2, 1.2)
        steps = length / len(t) * np.stack([np.cos(heading + bend * t), np.sin(heading + bend * t)], axis=1)
        points = np.round((start + np.cumsum(steps, axis=0)) * 16).astype(np.int32)
        strength = int(rng.uniform(90, 255))
        cv2.polylines(picture, [points], False, strength, max(1, round(width_px)), cv2.LINE_AA, shift=4)


def _floor_tone(
    kind: FloorKind, seed: int, shape: tuple[int, ...], bounds: Bounds, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Return the tone around 128 = the albedo itself (the shader's colour is doubled to match).

    What varies slowly is drawn on a coarser grid; only the grain is drawn texel by texel, and added in one pass.
    """
    height, width = shape[:2]
    grain = np.frombuffer(rng.bytes(height * width), np.uint8).reshape(height, width)
    finer = METRES_PER_TEXEL_COURSE / ((bounds[2] - bounds[0]) / width)
    gain = math.sqrt(finer) * kind.grain * 128 / 74  # 74: the standard deviation of a uniform byte
    tone = cv2.addWeighted(_part_of(_tone_field(kind, seed), shape, bounds), 1.0, grain, gain, -127.5 * gain)
    if kind.speckle:
        tone[grain < 256 * kind.speckle] = 128 + 112 * finer
    return np.asarray(tone, np.uint8)


COARSE = 4


def _coarse(shape: tuple[int, ...]) -> tuple[int, int]:
    return -(-shape[0] // COARSE), -(-shape[1] // COARSE)


def _refined(coarse: NDArray[np.floating], shape: tuple[int, ...]) -> NDArray[np.uint8]:
    """Return bytes on the fine grid."""
    return np.asarray(cv2.resize(np.clip(coarse, 0, 255).astype(np.uint8), (shape[1], shape[0])), np.uint8)


def _blotches(
    shape: tuple[int, ...], size_m: float, metres_per_texel: float, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return smooth noise of standard deviation about one."""
    height, width = shape[:2]
    cells = (max(2, round(height * metres_per_texel / size_m)), max(2, round(width * metres_per_texel / size_m)))
    coarse = rng.standard_normal(cells).astype(np.float32)
    return np.asarray(cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC), np.float32)


def wall_texture(kind: WallKind, seed: int, length_m: float, height_m: float) -> TwoTone:
    """Return one wall, (h, w, 2); row 0 is the top."""
    rng = stream(seed, "wall", round(length_m * 100))
    height, width = round(height_m / METRES_PER_TEXEL_HALL), round(length_m / METRES_PER_TEXEL_HALL)
    x = (np.arange(width, dtype=np.float64) + 0.5) * METRES_PER_TEXEL_HALL
    z = height_m - (np.arange(height, dtype=np.float64) + 0.5) * METRES_PER_TEXEL_HALL
    second = np.zeros((height, width), np.float32)
    spacing = rng.uniform(0.6, 1.4)  # the same kind of wall comes with narrower and wider joints
    second[_joints(kind, x / spacing, z / spacing)] = 1
    if kind.band_m:
        second[z < kind.band_m] = 1
    if kind.fold_m:
        second += 0.5 + 0.5 * np.sin(2 * np.pi * x / kind.fold_m + 0.8 * np.sin(x)).astype(np.float32)
    _draw_rectangles(second, kind.rectangles, rng)
    tone = 128 * (1 + 0.08 * _blotches(second.shape, 0.5, METRES_PER_TEXEL_HALL, rng))
    return _two_tone(np.clip(tone, 0, 255).astype(np.uint8), np.clip(255 * second, 0, 255).astype(np.uint8))


def _two_tone(tone: NDArray[np.uint8], second: NDArray[np.uint8]) -> TwoTone:
    return np.stack([tone, second], axis=2)


def _joints(kind: WallKind, x: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.bool_]:
    joints = np.zeros((len(z), len(x)), bool)
    shift = np.zeros(len(z))
    if kind.joint_z_m:
        joints |= (np.mod(z, kind.joint_z_m) < kind.joint_width_m)[:, None]
        shift = np.floor(z / kind.joint_z_m) % 2 * kind.joint_x_m / 2 * kind.staggered
    if kind.joint_x_m:
        joints |= np.mod(x[None, :] + shift[:, None], kind.joint_x_m) < kind.joint_width_m
    return joints


def _draw_rectangles(second: NDArray[np.float32], count: int, rng: np.random.Generator) -> None:
    height, width = second.shape
    for _ in range(count):
        w, h = int(rng.integers(20, 70)), int(rng.integers(25, 90))
        x, y = int(rng.integers(0, width - w)), int(rng.integers(0, max(1, height - h)))
        second[y : y + h, x : x + w] = rng.uniform(0.2, 1.0)
