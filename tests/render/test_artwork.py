"""The drawings: outlines, colours, symmetries, and that no two can be taken for one another."""

from itertools import combinations

import cv2
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from adc_bench.render.artwork import panel_picture, poster_picture, sign_picture
from adc_bench.world.categories import PANEL_SIGNS, SIGNS, SignCategory
from adc_bench.world.furniture import POSTERS
from adc_bench.world.signs import BOARD_M, SQUARES, TRIANGLES, VerticalSign, board_outline

BLUE, RED, WHITE, BLACK = (0, 117, 189), (255, 0, 0), (255, 255, 255), (0, 0, 0)
DISCS = tuple(sign for sign in SIGNS if sign not in TRIANGLES + SQUARES)


def share_of(picture: NDArray[np.uint8], colour: tuple[int, int, int]) -> float:
    """Return how much of the board has just this colour."""
    inside = picture[..., 3] == 255
    same = (picture[..., :3] == colour).all(axis=-1)
    return float((same & inside).sum() / inside.sum())


@pytest.mark.parametrize("sign", SIGNS)
def test_the_board_has_its_outline(sign: SignCategory) -> None:
    alpha = sign_picture(sign)[..., 3]
    pixel_m = BOARD_M / len(alpha)
    outline = board_outline(VerticalSign(name="", sign=sign, x_m=0, y_m=0, yaw_rad=0))
    rows, columns = np.indices(alpha.shape)
    x, y = (columns + 0.5) * pixel_m - BOARD_M / 2, BOARD_M / 2 - (rows + 0.5) * pixel_m
    board = shapely.Polygon(outline)
    well_inside = shapely.contains_xy(board.buffer(-1.5 * pixel_m), x, y)
    well_outside = ~shapely.contains_xy(board.buffer(1.5 * pixel_m), x, y)
    assert (alpha[well_inside] == 255).all() and (alpha[well_outside] == 0).all()


def test_families_have_their_colours() -> None:
    for sign in TRIANGLES:
        picture = sign_picture(sign)
        assert share_of(picture, RED) > 0.3 and share_of(picture, WHITE) > 0.3 and share_of(picture, BLUE) == 0
        assert 0.04 < share_of(picture, BLACK) < 0.25
    for sign in SQUARES + DISCS:
        picture = sign_picture(sign)
        assert share_of(picture, BLUE) > 0.4 and 0.1 < share_of(picture, WHITE) < 0.5 and share_of(picture, RED) == 0


@pytest.mark.parametrize("sign", ["sign_danger", "sign_dip", "sign_narrows", "sign_hospital"])
def test_symmetrical_signs_are_symmetrical(sign: SignCategory) -> None:
    picture = sign_picture(sign).astype(int)
    difference = np.abs(picture - picture[:, ::-1])
    assert difference.max() < 80 and difference.mean() < 0.05  # in a few pixels of an edge


def test_the_roundabout_looks_the_same_after_a_third_of_a_turn() -> None:
    picture = sign_picture("sign_roundabout")
    turn = cv2.getRotationMatrix2D((127.5, 127.5), 120, 1.0)
    turned = cv2.warpAffine(picture, turn, (256, 256)).astype(int)
    assert np.abs(turned - picture)[..., :3][picture[..., 3] == 255].mean() < 4


def test_left_is_left() -> None:
    white = (sign_picture("sign_turn_left")[..., :3] == WHITE).all(axis=-1)
    face = np.hypot(*(np.indices(white.shape) - 127.5)) < 115
    rows, columns = np.nonzero(white & face)
    head = columns < 90
    # the head is at the upper left, the shaft comes from below on the right
    assert head.any() and rows[head].max() < 150
    assert columns[rows > 180].min() > 128


def test_no_two_signs_look_alike_even_when_small() -> None:
    small = {sign: cv2.resize(sign_picture(sign)[..., :3], (24, 24), interpolation=cv2.INTER_AREA) for sign in SIGNS}
    for a, b in combinations(SIGNS, 2):
        assert np.abs(small[a].astype(int) - small[b]).mean() > 8, (a, b)


def test_edges_are_smooth() -> None:
    for sign in SIGNS:
        picture = sign_picture(sign)
        pure = sum(share_of(picture, colour) for colour in (BLUE, RED, WHITE, BLACK))
        assert 0.80 < pure < 1.0  # the rest are pixels that an edge crosses


def test_posters_have_their_format_and_differ() -> None:
    posters = [poster_picture(variant) for variant in range(10)]
    for variant, poster in enumerate(posters):
        _, width_m, height_m = POSTERS[variant % len(POSTERS)][0]
        height, width, channels = poster.shape
        assert channels == 3 and max(height, width) == 256
        assert width / height == pytest.approx(width_m / height_m, rel=0.02)
        assert (poster == BLUE).all(axis=-1).mean() == 0 and (poster == RED).all(axis=-1).mean() == 0
        assert poster.std() > 30
    assert len({poster.tobytes() for poster in posters}) == 10


def test_pictures_cannot_be_changed_by_who_gets_them() -> None:
    pictures = [*map(panel_picture, PANEL_SIGNS), *map(sign_picture, SIGNS), poster_picture(0)]
    assert all(not picture.flags.writeable for picture in pictures)
