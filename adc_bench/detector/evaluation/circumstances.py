"""The circumstances by which a detector is scored apart: of the picture (light, tunnel, blur), of the object (size,
distance, visible fraction).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.evaluation.score import Band
from adc_bench.world.frame import Conditions, Label
from adc_bench.world.look import LIGHT_LEVELS

# COCO's limits of 32 and 96 px, made for pictures about 640 px wide, as shares of the picture's width.
SMALL_SHARE, LARGE_SHARE = 0.05, 0.15
BLUR_PX = (0.5, 3.0)
CIRCUMSTANCES = ("light", "tunnel", "blur", "size", "distance", "visible")


class Bands(NamedTuple):
    """A quantity of objects in named bands; a value at a band's end belongs to both."""

    names: tuple[str, ...]
    bands: tuple[Band, ...]
    of_label: Callable[[Label], float]


def bands_of(width_px: int) -> dict[str, Bands]:
    """Return the bands for pictures of this width; an object's size is the root of its visible box' area."""
    small, large = SMALL_SHARE * width_px, LARGE_SHARE * width_px
    return {
        "size": Bands(
            (f"under {small:g} px", f"{small:g}-{large:g} px", f"over {large:g} px"),
            ((0.0, small), (small, large), (large, np.inf)),
            lambda label: box_side_px(label.box_px),
        ),
        "distance": Bands(
            ("under 1 m", "1-2 m", "2-4 m", "4-6 m", "over 6 m"),
            ((0.0, 1.0), (1.0, 2.0), (2.0, 4.0), (4.0, 6.0), (6.0, np.inf)),
            lambda label: label.distance_m,
        ),
        "visible": Bands(
            ("under half", "0.5-0.9", "over 0.9"),
            ((0.0, 0.5), (0.5, 0.9), (0.9, 1.0)),
            lambda label: min(label.visible_fraction, 1.0),
        ),
    }


def box_side_px(box: Sequence[float]) -> float:
    """Return the side of the square of a box' area."""
    x0, y0, x1, y1 = (float(value) for value in box)
    return float(np.sqrt(max(x1 - x0, 0.0) * max(y1 - y0, 0.0)))


def groups_of(source: LabelledPictures) -> dict[str, dict[str, list[int]]]:
    """Return the indices of the pictures of each light level, in and out of the tunnel, and of each band of blur."""
    named = {"light": _light, "tunnel": _tunnel, "blur": _blur}
    orders = {"light": tuple(LIGHT_LEVELS), "tunnel": ("inside", "outside"), "blur": _blur_names()}
    conditions = [source.conditions(i) for i in range(len(source))]
    groups: dict[str, dict[str, list[int]]] = {}
    for kind, name_of in named.items():
        names = [name_of(each) for each in conditions]
        members = {name: [i for i, own in enumerate(names) if own == name] for name in orders[kind]}
        groups[kind] = {name: indices for name, indices in members.items() if indices}
    return groups


def _light(conditions: Conditions) -> str:
    return conditions.light_level


def _tunnel(conditions: Conditions) -> str:
    return "inside" if conditions.in_tunnel else "outside"


def _blur(conditions: Conditions) -> str:
    return _blur_names()[int(np.searchsorted(BLUR_PX, conditions.blur_px, side="right"))]


def _blur_names() -> tuple[str, str, str]:
    low, high = BLUR_PX
    return f"under {low:g} px", f"{low:g}-{high:g} px", f"over {high:g} px"
