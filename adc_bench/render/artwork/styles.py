"""The ways in which panels and signs are drawn. All keep the regulation's colours and meanings; no two look alike.

Families of looks (`splits/*.toml`) share no style, so that a detector is judged on drawings that it has never seen.
"""

from collections.abc import Mapping

import msgspec

from adc_bench.render.artwork.canvas import Colour, Point


class Style(msgspec.Struct, frozen=True, kw_only=True):
    """One hand. The defaults are those of the standard style, the competition's figures among them.

    Attributes:
        weight: thickness of strokes, of the standard's.
        stretch: width and height of what is within a sign's border, of the standard's.
        head: length and width of arrow heads, of the standard's.
        swept: how far the wings of an arrow head reach back, of its length.
        triangle: how much of a danger triangle is white.
        face: how much of a square or disc is blue, or lies within the white line.
        inset: width of a white line within the blue, of half the board; 0 for a white edge. Triangles with an inset
            have a white edge as wide.
        fading: share of the print that has gone where most of it has.
        panel: size of what a panel shows, of the standard's.
        square_ends: whether a panel's strokes end square, not round.
        chequer: width and height of the chequer, of the panel's height.
        lit_green, lit_red, lit_yellow: linear light with nothing of the other colours: in the dark, where a camera
            exposes for the floor, a hundredth of them would wash a sign out.
    """

    weight: float = 1.0
    stretch: Point = (1.0, 1.0)
    head: Point = (1.0, 1.0)
    swept: float = 0.0
    triangle: float = 0.80
    face: float = 0.93
    inset: float = 0.0
    fading: float = 0.0
    blue: Colour = (0, 117, 189)
    red: Colour = (255, 0, 0)
    white: Colour = (255, 255, 255)
    black: Colour = (0, 0, 0)
    panel: float = 1.0
    square_ends: bool = False
    chequer: Point = (1.0, 1.0)
    lit_green: Colour = (0, 255, 0)
    lit_red: Colour = (255, 0, 0)
    lit_yellow: Colour = (255, 255, 0)


STYLES: Mapping[str, Style] = {
    # training
    "standard": Style(),
    "bold": Style(
        weight=1.22,
        head=(0.95, 1.15),
        triangle=0.74,
        face=0.90,
        blue=(0, 98, 176),
        red=(226, 12, 20),
        black=(22, 22, 24),
        panel=1.12,
        chequer=(1.15, 0.96),
        lit_green=(0, 230, 0),
        lit_red=(255, 0, 0),
        lit_yellow=(255, 214, 0),
    ),
    "slim": Style(
        weight=0.72,
        stretch=(0.92, 1.06),
        head=(1.15, 0.82),
        triangle=0.85,
        face=0.96,
        blue=(16, 132, 202),
        red=(240, 40, 32),
        white=(248, 246, 238),
        panel=0.92,
        square_ends=True,
        chequer=(1.0, 0.86),
        lit_green=(0, 240, 0),
        lit_red=(236, 0, 0),
        lit_yellow=(236, 255, 0),
    ),
    "barbed": Style(
        weight=0.88,
        stretch=(1.06, 0.95),
        head=(0.95, 1.1),
        swept=0.35,
        inset=0.05,
        face=0.94,
        triangle=0.78,
        fading=0.30,
        blue=(8, 106, 168),
        red=(214, 24, 30),
        white=(240, 238, 230),
        black=(34, 34, 36),
        square_ends=True,
        chequer=(1.3, 1.0),
        lit_green=(0, 250, 0),
        lit_red=(215, 0, 0),
        lit_yellow=(255, 236, 0),
    ),
    # validation
    "tall": Style(
        weight=0.92,
        stretch=(0.82, 1.12),
        head=(1.2, 0.92),
        triangle=0.82,
        inset=0.035,
        face=0.90,
        blue=(0, 110, 200),
        red=(236, 0, 26),
        black=(12, 12, 14),
        panel=1.05,
        square_ends=True,
        chequer=(0.86, 0.95),
        lit_green=(0, 255, 0),
        lit_red=(245, 0, 0),
        lit_yellow=(245, 240, 0),
    ),
    "enamel": Style(
        weight=1.12,
        stretch=(0.96, 0.92),
        head=(0.85, 1.05),
        swept=0.15,
        triangle=0.77,
        face=0.91,
        fading=0.15,
        blue=(12, 92, 158),
        red=(206, 18, 22),
        white=(236, 238, 242),
        black=(18, 18, 20),
        panel=0.88,
        chequer=(1.2, 0.9),
        lit_green=(0, 205, 0),
        lit_red=(230, 0, 0),
        lit_yellow=(250, 196, 0),
    ),
    # test
    "broad": Style(
        weight=1.08,
        stretch=(1.1, 0.9),
        head=(0.82, 1.2),
        triangle=0.76,
        face=0.95,
        inset=0.06,
        blue=(0, 124, 196),
        red=(246, 22, 14),
        white=(252, 252, 250),
        panel=1.08,
        chequer=(1.4, 0.92),
        lit_green=(0, 245, 0),
        lit_red=(250, 0, 0),
        lit_yellow=(255, 248, 0),
    ),
    "weathered": Style(
        weight=0.82,
        stretch=(0.88, 0.9),
        head=(1.05, 0.95),
        swept=0.25,
        triangle=0.83,
        face=0.92,
        fading=0.42,
        blue=(24, 112, 172),
        red=(224, 44, 40),
        white=(232, 230, 220),
        black=(44, 44, 46),
        panel=0.84,
        square_ends=True,
        chequer=(0.95, 0.84),
        lit_green=(0, 190, 0),
        lit_red=(205, 0, 0),
        lit_yellow=(215, 190, 0),
    ),
    "stout": Style(
        weight=1.3,
        stretch=(0.94, 0.86),
        head=(0.9, 1.05),
        triangle=0.72,
        face=0.88,
        fading=0.12,
        blue=(0, 102, 182),
        red=(232, 8, 12),
        black=(8, 8, 10),
        panel=0.98,
        chequer=(1.08, 1.0),
        lit_green=(0, 236, 0),
        lit_red=(255, 0, 0),
        lit_yellow=(255, 226, 0),
    ),
}
