"""Posters for the hall's walls: things with print, blocks of colour and emblems that are none of our signs."""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from adc_bench.render.artwork.canvas import Canvas, Colour, arc
from adc_bench.world.streams import stream

WIDTH_PX, HEIGHT_PX = 192, 256
HALF = WIDTH_PX / HEIGHT_PX  # half the width in the canvas' units
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
    """Return a poster (256, 192, 3) uint8 RGB; equal variants give equal posters, the first POSTERS are all kinds."""
    rng = stream(variant, "poster")
    inks = INKS[variant % len(INKS)]
    poster = Canvas(WIDTH_PX, HEIGHT_PX, inks[0])
    _KINDS[variant % len(_KINDS)](poster, rng, inks)
    picture = poster.picture()
    picture.setflags(write=False)
    return picture


_Inks = tuple[Colour, Colour, Colour, Colour]


def _print(poster: Canvas, rng: np.random.Generator, top: float, bottom: float, ink: Colour, line: float) -> None:
    """Fill the page between two heights with lines of words, `line` from one to the next."""
    y = top - line
    while y > bottom:
        x, end = -HALF + 0.1, HALF - 0.1 - rng.uniform(0, 0.3)
        while x < end:
            word = min(rng.uniform(0.8, 3.2) * line, end - x)
            poster.box(x, y, x + word, y + 0.55 * line, ink)
            x += word + 0.35 * line
        y -= line


def _talk(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A talk: a title on a band, print, three emblems."""
    _, ink, strong, second = inks
    poster.box(-HALF, 0.45, HALF, 1, strong)
    _print(poster, rng, 0.92, 0.52, inks[0], 0.18)
    _print(poster, rng, 0.38, -0.6, ink, 0.075)
    for x, colour in ((-0.45, second), (0.0, ink), (0.45, strong)):
        poster.disc((x, -0.8), 0.12, colour)
        poster.box(x - 0.03, -0.88, x + 0.09, -0.76, inks[0])


def _landscape(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A landscape: sky, sun, two ranges of hills, a caption."""
    paper, ink, strong, second = inks
    poster.box(-HALF, -0.6, HALF, 1, (150, 190, 215))
    poster.disc((0.3, 0.55), 0.2, (250, 220, 140))
    x = np.linspace(-HALF, HALF, 40)
    for height, colour in ((0.15, strong), (-0.15, second)):
        ridge = height + 0.12 * np.sin(x * rng.uniform(4, 8) + rng.uniform(0, 6)) + 0.05 * np.sin(x * 17)
        poster.polygon([(-HALF, -0.6), *zip(x, ridge, strict=True), (HALF, -0.6)], colour)
    poster.box(-HALF, -1, HALF, -0.6, paper)
    _print(poster, rng, -0.66, -0.95, ink, 0.1)


def _chart(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A research poster: a title, two columns' bars and curves, print."""
    _, ink, strong, second = inks
    _print(poster, rng, 0.96, 0.7, strong, 0.13)
    _print(poster, rng, 0.66, 0.3, ink, 0.06)
    for k, height in enumerate(rng.uniform(0.1, 0.5, 8)):
        poster.box(-0.62 + 0.07 * k, -0.35, -0.57 + 0.07 * k, -0.35 + height, second if k % 2 else strong)
    x = np.linspace(0.05, 0.62, 30)
    for phase, colour in ((0.0, strong), (1.0, ink)):
        poster.stroke(np.column_stack([x, -0.1 + 0.2 * np.sin(9 * x + phase)]), 0.025, colour)
    poster.stroke([(0.05, 0.2), (0.05, -0.35), (0.05, -0.36)], 0.015, ink)
    poster.stroke([(0.05, -0.35), (0.62, -0.35)], 0.015, ink)
    _print(poster, rng, -0.42, -0.95, ink, 0.06)


def _sponsors(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A wall of sponsors' emblems: rings, bars and dots, each with a name under it."""
    _, ink, strong, second = inks
    for row, y in enumerate((0.62, 0.02, -0.58)):
        for column, x in enumerate((-0.36, 0.36)):
            colour = (strong, second, ink)[(row + 2 * column) % 3]
            if (row + column) % 3 == 0:
                poster.stroke(arc((x, y), 0.15, 20, 320), 0.08, colour)
            elif (row + column) % 3 == 1:
                for k in range(3):
                    poster.box(x - 0.2 + 0.14 * k, y - 0.15, x - 0.1 + 0.14 * k, y - 0.05 + 0.1 * k, colour)
            else:
                for k in range(5):
                    poster.disc((x + 0.16 * np.cos(k * 1.257), y + 0.16 * np.sin(k * 1.257)), 0.06, colour)
            width = rng.uniform(0.1, 0.22)
            poster.box(x - width, y - 0.28, x + width, y - 0.22, ink)


def _slanted(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A concert bill: slanted blocks and big letters."""
    paper, ink, strong, second = inks
    poster.polygon([(-HALF, -0.2), (HALF, 0.5), (HALF, 1), (-HALF, 1)], strong)
    poster.polygon([(-HALF, -0.75), (HALF, -0.05), (HALF, 0.2), (-HALF, -0.5)], second)
    _print(poster, rng, 0.9, 0.3, paper, 0.25)
    _print(poster, rng, -0.62, -0.95, ink, 0.11)


def _robot(poster: Canvas, rng: np.random.Generator, inks: _Inks) -> None:
    """A club's poster: a robot's head over its name."""
    paper, ink, strong, second = inks
    poster.box(-0.45, -0.1, 0.45, 0.6, second, corner=0.12)
    poster.box(-0.03, 0.58, 0.03, 0.8, ink)
    poster.disc((0, 0.83), 0.07, strong)
    for x in (-0.2, 0.2):
        poster.disc((x, 0.32), 0.11, paper)
        poster.disc((x + 0.02, 0.32), 0.05, ink)
    poster.box(-0.22, 0.02, 0.22, 0.08, ink)
    poster.box(-HALF, -0.62, HALF, -0.3, strong)
    _print(poster, rng, -0.32, -0.6, paper, 0.22)
    _print(poster, rng, -0.66, -0.95, ink, 0.08)


_KINDS: tuple[Callable[[Canvas, np.random.Generator, _Inks], None], ...] = (
    _talk,
    _landscape,
    _chart,
    _sponsors,
    _slanted,
    _robot,
)
POSTERS = len(_KINDS) * len(INKS)  # different in kind or colours
