"""The drawings: outlines, colours, symmetries, and that no two can be taken for one another."""

from itertools import combinations

import cv2
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from adc_bench.render.artwork import panel_picture, poster_picture, sign_picture
from adc_bench.render.artwork.styles import STYLES
from adc_bench.world.categories import PANEL_SIGNS, SIGNS, SignCategory
from adc_bench.world.furniture import POSTERS
from adc_bench.world.look import ARTWORKS
from adc_bench.world.signs import BOARD_M, SQUARES, TRIANGLES, VerticalSign, board_outline

BLUE, RED, WHITE, BLACK = (0, 117, 189), (255, 0, 0), (255, 255, 255), (0, 0, 0)
DISCS = tuple(sign for sign in SIGNS if sign not in TRIANGLES + SQUARES)


def share_of(picture: NDArray[np.uint8], colour: tuple[int, int, int]) -> float:
    """Return how much of the board has just this colour."""
    inside = picture[..., 3] == 255
    same = (picture[..., :3] == colour).all(axis=-1)
    return float((same & inside).sum() / inside.sum())


@pytest.mark.parametrize("artwork", ARTWORKS)
@pytest.mark.parametrize("sign", SIGNS)
def test_the_board_has_its_outline(sign: SignCategory, artwork: str) -> None:
    alpha = sign_picture(sign, artwork)[..., 3]
    pixel_m = BOARD_M / len(alpha)
    outline = board_outline(VerticalSign(name="", sign=sign, x_m=0, y_m=0, yaw_rad=0))
    rows, columns = np.indices(alpha.shape)
    x, y = (columns + 0.5) * pixel_m - BOARD_M / 2, BOARD_M / 2 - (rows + 0.5) * pixel_m
    board = shapely.Polygon(outline)
    well_inside = shapely.contains_xy(board.buffer(-1.5 * pixel_m), x, y)
    well_outside = ~shapely.contains_xy(board.buffer(1.5 * pixel_m), x, y)
    assert (alpha[well_inside] == 255).all() and (alpha[well_outside] == 0).all()


def test_families_have_the_regulation_s_colours() -> None:
    for sign in TRIANGLES:
        picture = sign_picture(sign, "standard")
        assert share_of(picture, RED) > 0.3 and share_of(picture, WHITE) > 0.3 and share_of(picture, BLUE) == 0
        assert 0.04 < share_of(picture, BLACK) < 0.25
    for sign in SQUARES + DISCS:
        picture = sign_picture(sign, "standard")
        assert share_of(picture, BLUE) > 0.4 and 0.1 < share_of(picture, WHITE) < 0.5 and share_of(picture, RED) == 0


@pytest.mark.parametrize("sign", ["sign_danger", "sign_dip", "sign_narrows", "sign_hospital"])
def test_symmetrical_signs_are_symmetrical(sign: SignCategory) -> None:
    picture = sign_picture(sign, "standard").astype(int)
    difference = np.abs(picture - picture[:, ::-1])
    assert difference.max() < 80 and difference.mean() < 0.05  # in a few pixels of an edge


def test_the_roundabout_looks_the_same_after_a_third_of_a_turn() -> None:
    picture = sign_picture("sign_roundabout", "standard")
    turn = cv2.getRotationMatrix2D((127.5, 127.5), 120, 1.0)
    turned = cv2.warpAffine(picture, turn, (256, 256)).astype(int)
    assert np.abs(turned - picture)[..., :3][picture[..., 3] == 255].mean() < 4


def test_left_is_left() -> None:
    white = (sign_picture("sign_turn_left", "standard")[..., :3] == WHITE).all(axis=-1)
    face = np.hypot(*(np.indices(white.shape) - 127.5)) < 115
    rows, columns = np.nonzero(white & face)
    head = columns < 90
    # the head is at the upper left, the shaft comes from below on the right
    assert head.any() and rows[head].max() < 150
    assert columns[rows > 180].min() > 128


def stretched(picture: NDArray[np.uint8], across: float, up: float) -> NDArray[np.float32]:
    """Return a picture (h, w, 3), stretched about its middle, as small as from far away."""
    height, width = picture.shape[:2]
    place = np.array([[across, 0, (1 - across) * (width - 1) / 2], [0, up, (1 - up) * (height - 1) / 2]])
    moved = cv2.warpAffine(picture, place, (width, height), borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(cv2.resize(moved, (width // 6, height // 6), interpolation=cv2.INTER_AREA), np.float32)


def contrasts(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a picture of mean 0 and variance 1: the mean of two such pictures' product is their correlation."""
    return np.asarray((picture - picture.mean()) / picture.std(), np.float32)


def glyph(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return what is ink and what is not (h, w, 3) within a sign's border: print is told by its red channel."""
    red = picture[24:232, 24:232, 0]
    _, ink = cv2.threshold(np.ascontiguousarray(red), 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    return np.dstack([ink] * 3)


@pytest.mark.parametrize("artwork", ARTWORKS)
def test_whoever_knows_the_standard_style_recognises_every_sign_of_every_other(artwork: str) -> None:
    signs = {style: [glyph(sign_picture(sign, style)) for sign in SIGNS] for style in ("standard", artwork)}
    panels = {style: [panel_picture(sign, style)[..., :3] for sign in PANEL_SIGNS] for style in ("standard", artwork)}
    sizes = [(across, up) for across in (0.75, 0.87, 1.0, 1.15, 1.33) for up in (0.75, 0.87, 1.0, 1.15, 1.33)]
    for drawn in (signs, panels):
        known = np.stack([contrasts(stretched(picture, 1, 1)) for picture in drawn["standard"]])
        for k, picture in enumerate(drawn[artwork]):
            shown = np.stack([contrasts(stretched(picture, *size)) for size in sizes])
            alike = [(one * shown).mean(axis=(1, 2, 3)).max() for one in known]
            assert np.argmax(alike) == k, alike


def test_no_two_styles_look_alike() -> None:
    for a, b in combinations(ARTWORKS, 2):
        for sign in SIGNS:
            first, second = (sign_picture(sign, artwork)[..., :3].astype(int) for artwork in (a, b))
            assert np.abs(first - second).mean() > 3, (a, b, sign)
        for shown in PANEL_SIGNS:
            first, second = (panel_picture(shown, artwork)[..., :3].astype(int) for artwork in (a, b))
            assert np.abs(first - second).mean() > 1, (a, b, shown)


@pytest.mark.parametrize("artwork", ARTWORKS)
def test_no_two_signs_look_alike_even_when_small(artwork: str) -> None:
    pictures = {
        sign: cv2.resize(sign_picture(sign, artwork)[..., :3], (24, 24), interpolation=cv2.INTER_AREA).astype(int)
        for sign in SIGNS
    }
    for a, b in combinations(SIGNS, 2):
        assert np.abs(pictures[a] - pictures[b]).mean() > 5, (a, b)


def hue_deg(colour: tuple[int, int, int]) -> float:
    ((hue, _, _),) = cv2.cvtColor(np.array([[colour]], np.float32) / 255, cv2.COLOR_RGB2HSV)[0]
    return float(hue)


def test_every_style_keeps_the_regulation_s_hues() -> None:
    assert tuple(STYLES) == ARTWORKS
    for style in STYLES.values():
        assert abs(hue_deg(style.blue) - hue_deg(BLUE)) < 12
        assert all((hue_deg(red) + 180) % 360 == pytest.approx(180, abs=10) for red in (style.red, style.lit_red))
        assert (
            style.lit_green[0] == style.lit_green[2] == style.lit_red[1] == style.lit_red[2] == style.lit_yellow[2] == 0
        )
        assert hue_deg(style.lit_yellow) == pytest.approx(60, abs=14)
        assert min(style.white) > 215 and max(style.black) < 50


@pytest.mark.parametrize("artwork", ARTWORKS)
def test_panels_show_one_colour_on_black_and_the_chequer_two(artwork: str) -> None:
    style = STYLES[artwork]
    lit = {"up": style.lit_green, "left": style.lit_green, "right": style.lit_green}
    lit |= {"stop": style.lit_red, "park": style.lit_yellow}
    for sign, colour in lit.items():
        picture = panel_picture(sign, artwork)[..., :3].reshape(-1, 3)
        same, dark = (picture == colour).all(axis=1), (picture == 0).all(axis=1)
        assert 0.03 < same.mean() < 0.33 and dark.mean() > 0.6 and (same | dark).mean() > 0.95
    up, left, right = (panel_picture(sign, artwork)[..., :3].astype(int) for sign in ("up", "left", "right"))
    assert np.abs(left - right[:, ::-1]).mean() < 0.5
    assert np.abs(np.rot90(up[:, 56:200]) - left[:, 56:200]).mean() < 2


def test_edges_are_smooth() -> None:
    for sign in SIGNS:
        picture = sign_picture(sign, "standard")
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
    panels = [panel_picture(sign, "tall") for sign in PANEL_SIGNS]
    pictures = [*panels, *(sign_picture(sign, "weathered") for sign in SIGNS), poster_picture(0)]
    assert all(not picture.flags.writeable for picture in pictures)
