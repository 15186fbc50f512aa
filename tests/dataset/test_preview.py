"""The preview draws every category in a colour of its kind, and ignore regions in grey."""

import numpy as np
import pytest

from adc_bench.dataset.preview import COLOURS, IGNORED_COLOUR, draw_labels
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID
from adc_bench.world.frame import Label


def label_of(category: str, *, ignore: bool = False) -> Label:
    return Label(
        category_id=CATEGORY_ID[category],
        instance=category,
        box_px=(40, 60, 120, 140),
        amodal_box_px=(40, 60, 120, 140),
        visible_px=6400,
        visible_fraction=1.0,
        truncation=0.0,
        distance_m=1.0,
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
