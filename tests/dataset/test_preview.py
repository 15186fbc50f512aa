"""The preview: colours by kind, pictures of every kind, marks where the labels are."""

import re
from collections import Counter
from pathlib import Path

import cv2
import numpy as np
import pycocotools.mask
import pytest

from adc_bench.dataset import FrameDataset
from adc_bench.dataset.preview import contact_sheet, page_of
from adc_bench.dataset.preview.choose import spread
from adc_bench.dataset.preview.colours import COLOURS, IGNORED_COLOUR
from adc_bench.dataset.preview.overlay import overlay
from adc_bench.dataset.preview.sheet import draw_labels
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID
from adc_bench.world.frame import NO_KEYPOINTS, Label


def mask_runs(mask: np.ndarray) -> bytes:
    return pycocotools.mask.encode(np.asfortranarray(mask, np.uint8))["counts"]


def label_of(category: str, *, ignore: bool = False, mask: np.ndarray | None = None) -> Label:
    box = (40.0, 60.0, 120.0, 140.0)
    return Label(
        category_id=CATEGORY_ID[category],
        instance=category,
        box_px=box,
        amodal_box_px=box,
        amodal_box_whole_px=box,
        mask_rle=mask_runs(np.zeros((240, 320)) if mask is None else mask),
        visible_px=6400,
        visible_fraction=1.0,
        truncation=0.0,
        distance_m=1.0,
        pose_world_object=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        keypoints_px=NO_KEYPOINTS,
        ignore=ignore,
    )


@pytest.mark.parametrize("category", CATEGORIES)
def test_a_box_has_the_colour_of_its_kind(category: str) -> None:
    blank = np.zeros((240, 320, 3), np.uint8)
    drawn = draw_labels(blank, [label_of(category)])
    assert tuple(drawn[100, 40]) == tuple(drawn[139, 119]) == COLOURS[category.split("_")[0]]
    assert tuple(draw_labels(blank, [label_of(category, ignore=True)])[100, 40]) == IGNORED_COLOUR
    assert not blank.any()


def test_kinds_have_different_colours() -> None:
    assert len({*COLOURS.values(), IGNORED_COLOUR}) == len(COLOURS) + 1


def test_the_sheet_has_a_row_for_each_light_level_and_the_tunnel(rendered: Path) -> None:
    dataset = FrameDataset(rendered)
    sheet = contact_sheet(dataset, per_camera=2)
    assert sheet.shape == (5 * 240, 4 * 320, 3)
    found = [dataset.conditions(i) for i in range(len(dataset)) if dataset.camera(i) == "road"]
    kinds = {"tunnel" if one.in_tunnel else one.light_level for one in found}
    for row, kind in enumerate(("dark", "dim", "normal", "bright", "tunnel")):
        assert sheet[240 * row : 240 * (row + 1), :320].any() == (kind in kinds)


def test_pictures_are_spread_over_all_kinds(rendered: Path) -> None:
    dataset = FrameDataset(rendered)
    chosen = spread(dataset, 16)
    assert len(chosen) == len(set(chosen)) == 16 and chosen == sorted(chosen)
    assert set(Counter(dataset.camera(i) for i in chosen).values()) == {8}
    levels = {dataset.conditions(i).light_level for i in range(70)}
    assert {dataset.conditions(i).light_level for i in chosen} == levels
    assert {dataset.scenario(i).layout.name for i in chosen} == {dataset.scenario(i).layout.name for i in range(70)}
    assert spread(dataset, 1000) == list(range(70))


@pytest.mark.parametrize("seed", range(4))
def test_a_mask_is_covered_by_its_path(seed: int) -> None:
    """Fill the path's outlines with OpenCV, borders included: all of the mask, holes and thin parts, and no more."""
    rng = np.random.default_rng(seed)
    mask = cv2.GaussianBlur(rng.random((240, 320)), (0, 0), 4) > 0.51
    mask[10, 5:60] = mask[20:70, 300] = True
    path = re.search(r'class="mask" d="([^"]*)"', overlay([label_of("cone", mask=mask)], [], (320, 240)))[1]
    outlines = [np.array(re.findall(r"[\d.]+", part), float).reshape(-1, 2) for part in path.split("M")[1:]]
    drawn = np.zeros((240, 320), np.uint8)
    cv2.fillPoly(drawn, [np.floor(outline).astype(np.int32) for outline in outlines], 1)
    for outline in outlines:
        cv2.polylines(drawn, [np.floor(outline).astype(np.int32)], True, 1)
    np.testing.assert_array_equal(drawn.astype(bool), mask)


def test_the_page_is_the_same_each_time_and_holds_the_pictures_as_delivered(rendered: Path) -> None:
    dataset = FrameDataset(rendered)
    page = page_of(dataset, 6)
    assert page == page_of(dataset, 6) and page.count(b"<figure ") == 6
    assert page.count(b"data:image/jpeg;base64,") == 6
