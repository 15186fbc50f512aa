"""The twelve vertical signs' boards in a style: white triangles edged red, blue squares, blue discs.

Families, meanings and colours as the competition has them; the drawings are our own.
"""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.render.artwork.canvas import Array, Canvas, Colour
from adc_bench.render.artwork.glyphs import GLYPHS
from adc_bench.render.artwork.styles import STYLES, Style
from adc_bench.world.categories import SignCategory
from adc_bench.world.signs import BOARD_M, TRIANGLES, VerticalSign, board_outline
from adc_bench.world.streams import stream

SIZE_PX = 256  # of the square around the board
SHAPE, OUTSIDE = (255, 255, 255), (0, 0, 0)
TRIANGLE_MIDDLE = (0.0, -0.35)  # of what stands in a triangle
FADING_GRID = 6  # patches along a side


@lru_cache(maxsize=64)
def sign_picture(sign: SignCategory, artwork: str) -> NDArray[np.uint8]:
    """Return the front (256, 256, 4) uint8 RGBA of a sign's board in a style of `STYLES`, transparent outside its
    outline.

    The picture is the square BOARD_M wide around the board's middle; its edge colour goes on outside the outline.
    """
    style = STYLES[artwork]
    outline = board_outline(VerticalSign(name=sign, sign=sign, x_m=0.0, y_m=0.0, yaw_rad=0.0)) * 2 / BOARD_M
    is_triangle = sign in TRIANGLES
    board = _bordered_triangle(outline, style) if is_triangle else _bordered(outline, style)
    board.stretch(style.stretch, TRIANGLE_MIDDLE if is_triangle else (0.0, 0.0))
    GLYPHS[sign](board, style)
    shape = Canvas(SIZE_PX, SIZE_PX, OUTSIDE)
    shape.polygon(outline, SHAPE)
    rgb = _faded(board.picture(), style.fading, style.white, stream(0, "fading", sign, artwork))
    rgba = np.dstack([rgb, cv2.extractChannel(shape.picture(), 0)])
    rgba.setflags(write=False)
    return rgba


def _bordered_triangle(outline: Array, style: Style) -> Canvas:
    """Return a board with a white triangle in a red one, in a white one if there is an inset."""
    board = Canvas(SIZE_PX, SIZE_PX, style.white if style.inset else style.red)
    board.polygon(_within_triangle(outline, 1 - 2 * style.inset), style.red)
    board.polygon(_within_triangle(outline, style.triangle), style.white)
    return board


def _bordered(outline: Array, style: Style) -> Canvas:
    """Return a blue board with a white edge, or with a white line within."""
    board = Canvas(SIZE_PX, SIZE_PX, style.blue if style.inset else style.white)
    board.polygon(outline * style.face, style.white if style.inset else style.blue)
    board.polygon(outline * (style.face - style.inset), style.blue)
    return board


def _within_triangle(outline: Array, share: float) -> Array:
    """Shrink a triangle towards the centre of the circle in it, so that its edge is equally wide all round."""
    sides = np.linalg.norm(np.roll(outline, -1, axis=0) - np.roll(outline, 1, axis=0), axis=1)
    centre = sides @ outline / sides.sum()
    shrunk: Array = centre + share * (outline - centre)
    return shrunk


def _faded(rgb: NDArray[np.uint8], fading: float, paper: Colour, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return a print (h, w, 3) that has faded in patches, most of it by up to `fading`, to the paper's colour."""
    if not fading:
        return rgb
    patches = rng.random((FADING_GRID, FADING_GRID)).astype(np.float32)
    gone = fading * np.clip(cv2.resize(patches, rgb.shape[1::-1], interpolation=cv2.INTER_CUBIC), 0, 1)[..., None]
    return np.asarray(np.round(rgb + gone * (np.array(paper) - rgb)), np.uint8)
