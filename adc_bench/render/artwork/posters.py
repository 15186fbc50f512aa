"""Posters for the hall's walls: things with print, blocks of colour and emblems that are none of our signs."""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from adc_bench.render.artwork.canvas import Canvas, Colour, arc
from adc_bench.world.furniture import POSTERS
from adc_bench.world.streams import stream

LONG_SIDE_PX = 256
# Paper, ink, and two strong colours of each print run; no pure blue, red or green beside white as our signs have.
INKS: tuple[tuple[Colour, Colour, Colour, Colour], ...] = (
    ((244, 240, 228), (40, 38, 36), (226, 120, 30), (70, 60, 90)),
    ((250, 250, 248), (30, 30, 40), (20, 130, 120), (240, 190, 60)),
    ((34, 36, 48), (235, 232, 220), (210, 70, 120), (120, 200, 210)),
    ((250, 214, 80), (30, 26, 20), (90, 40, 110), (245, 245, 240)),
    ((222, 232, 238), (24, 42, 66), (130, 60, 40), (60, 120, 70)),
)


@cache
def poster_picture(variant: int) -> NDArray[np.uint8]:
    """Return a poster (h, w, 3) uint8 RGB in the format of this variant in the hall, its long side 256 pixels."""
    rng = stream(variant, "poster")
    inks = INKS[variant % len(INKS)]
    _, width_m, height_m = POSTERS[variant % len(POSTERS)][0]
    scale = LONG_SIDE_PX / max(width_m, height_m)
    poster = Canvas(round(width_m * scale), round(height_m * scale), inks[0])
    _KINDS[variant % len(_KINDS)](poster, rng, inks)
    picture = poster.picture()
    picture.setflags(write=False)
    return picture


_Inks = tuple[Colour, Colour, Colour, Colour]


def _print(poster: Canvas, rng: np.random.Generator, top: float, bottom: float, ink: Colour, line: float) -> None:
    """Fill the page between two heights with lines of words, `line` from one to the next."""
    y = top - line
    while y > bottom:
        x, end = 0.1 - poster.half_width, poster.half_width - 0.1 - rng.uniform(0, 0.3)
        while x < end:
            word = min(rng.uniform(0.8, 3.2) * line, end - x)
            poster.box(x, y, x + word, y + 0.55 * line, ink)
            x += word + 0.35 * line
        y -= line


def _talk(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A talk: a title on a band, print, three emblems."""
    _, ink, strong, second = inks
    wide = poster.half_width
    poster.box(-wide, 0.45, wide, 1, strong)
    _print(poster, rng, 0.92, 0.52, inks[0], 0.18)
    _print(poster, rng, 0.38, -0.6, ink, 0.075)
    for x, colour in ((-0.6 * wide, second), (0.0, ink), (0.6 * wide, strong)):
        poster.disc((x, -0.8), 0.12, colour)
        poster.box(x - 0.03, -0.88, x + 0.09, -0.76, inks[0])


def _landscape(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A landscape: sky, sun, two ranges of hills, a caption."""
    paper, ink, strong, second = inks
    wide = poster.half_width
    poster.box(-wide, -0.6, wide, 1, (150, 190, 215))
    poster.disc((0.4 * wide, 0.55), 0.2, (250, 220, 140))
    x = np.linspace(-wide, wide, 80)
    for height, colour in ((0.15, strong), (-0.15, second)):
        ridge = height + 0.12 * np.sin(x * rng.uniform(4, 8) + rng.uniform(0, 6)) + 0.05 * np.sin(x * 17)
        poster.polygon([(-wide, -0.6), *zip(x, ridge, strict=True), (wide, -0.6)], colour)
    poster.box(-wide, -1, wide, -0.6, paper)
    _print(poster, rng, -0.66, -0.95, ink, 0.1)


def _chart(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A research poster: a title, print, bars, two curves."""
    _, ink, strong, second = inks
    wide = poster.half_width
    _print(poster, rng, 0.96, 0.7, strong, 0.13)
    _print(poster, rng, 0.66, 0.3, ink, 0.06)
    for k, height in enumerate(rng.uniform(0.1, 0.5, 8)):
        x = wide * (-0.85 + 0.1 * k)
        poster.box(x, -0.35, x + 0.07 * wide, -0.35 + height, second if k % 2 else strong)
    along = np.linspace(0.0, 1.0, 60)
    for phase, colour in ((0.0, strong), (1.0, ink)):
        poster.stroke(
            np.column_stack([wide * (0.1 + 0.8 * along), -0.1 + 0.2 * np.sin(6 * along + phase)]), 0.025, colour
        )
    poster.box(0.1 * wide - 0.01, -0.36, 0.1 * wide + 0.01, 0.2, ink)
    poster.box(0.1 * wide, -0.36, 0.9 * wide, -0.34, ink)
    _print(poster, rng, -0.42, -0.95, ink, 0.06)


def _sponsors(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A wall of sponsors' emblems: open rings, steps and dots, each with a name under it."""
    _, ink, strong, second = inks
    wide = poster.half_width
    size = min(1.0, 1.3 * wide)
    for row, y in enumerate((0.62, 0.02, -0.58)):
        for column, x in enumerate((-0.5 * wide, 0.5 * wide)):
            colour = (strong, second, ink)[(row + 2 * column) % 3]
            _EMBLEMS[(row + column) % 3](poster, x, y, size, colour)
            width = size * rng.uniform(0.1, 0.22)
            poster.box(x - width, y - 0.28, x + width, y - 0.22, ink)


def _open_ring(poster: Canvas, x: float, y: float, size: float, colour: Colour) -> None:
    poster.stroke(arc((x, y), 0.15 * size, 20, 320), 0.08 * size, colour)


def _steps(poster: Canvas, x: float, y: float, size: float, colour: Colour) -> None:
    for k in (-1, 0, 1):
        at = x + 0.14 * k * size
        poster.box(at - 0.05 * size, y - 0.15 * size, at + 0.05 * size, y + (0.05 + 0.1 * k) * size, colour)


def _dots(poster: Canvas, x: float, y: float, size: float, colour: Colour) -> None:
    for dot_x, dot_y in arc((x, y), 0.16 * size, 0, 288, 5):
        poster.disc((float(dot_x), float(dot_y)), 0.06 * size, colour)


def _slanted(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A concert bill: slanted blocks and big letters."""
    paper, ink, strong, second = inks
    wide = poster.half_width
    poster.polygon([(-wide, -0.2), (wide, 0.5), (wide, 1), (-wide, 1)], strong)
    poster.polygon([(-wide, -0.75), (wide, -0.05), (wide, 0.2), (-wide, -0.5)], second)
    _print(poster, rng, 0.9, 0.3, paper, 0.25)
    _print(poster, rng, -0.62, -0.95, ink, 0.11)


def _robot(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A club's poster: a robot's head over its name."""
    paper, ink, strong, second = inks
    wide = poster.half_width
    poster.box(-0.6 * wide, -0.1, 0.6 * wide, 0.6, second, corner=0.12)
    poster.box(-0.03, 0.58, 0.03, 0.8, ink)
    poster.disc((0, 0.83), 0.07, strong)
    for x in (-0.27 * wide, 0.27 * wide):
        poster.disc((x, 0.32), 0.11, paper)
        poster.disc((x + 0.02, 0.32), 0.05, ink)
    poster.box(-0.3 * wide, 0.02, 0.3 * wide, 0.08, ink)
    poster.box(-wide, -0.62, wide, -0.3, strong)
    _print(poster, rng, -0.32, -0.6, paper, 0.22)
    _print(poster, rng, -0.66, -0.95, ink, 0.08)


_EMBLEMS: tuple[Callable[[Canvas, float, float, float, Colour], None], ...] = (_open_ring, _steps, _dots)
_KINDS: tuple[Callable[[Canvas, np.random.Generator, _Inks], None], ...] = (
    _talk,
    _landscape,
    _chart,
    _sponsors,
    _slanted,
    _robot,
)
