"""Labels drawn over a picture, as SVG: a class for each kind of mark, so that a page can switch it on and off."""

from collections.abc import Sequence
from html import escape

import cv2
import numpy as np
import pycocotools.mask

from adc_bench.dataset.preview.colours import colour_of
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import KEYPOINT_OUTSIDE, KEYPOINT_VISIBLE, BoxPx, Label, LaneLine


def overlay(labels: Sequence[Label], lines: Sequence[LaneLine], size_px: tuple[int, int]) -> str:
    """Return the SVG element of a picture's labels and lane lines, in the picture's pixels."""
    width, height = size_px
    marks = [*(_lane_line(line) for line in lines), *(_label(label, size_px) for label in labels)]
    return f'<svg viewBox="0 0 {width} {height}" aria-hidden="true">{"".join(marks)}</svg>'


def _label(label: Label, size_px: tuple[int, int]) -> str:
    name = CATEGORIES[label.category_id - 1]
    red, green, blue = colour_of(name, ignored=label.ignore)
    told = f"{name}, {label.instance}, {label.distance_m:.2f} m, {label.visible_fraction:.0%} visible"
    x, y = label.box_px[0], max(label.box_px[1] - 2, 8)
    corners = "".join(
        f'<circle class="keypoint{"" if seen == KEYPOINT_VISIBLE else " hidden"}" cx="{u:.1f}" cy="{v:.1f}" r="2.2"/>'
        for u, v, seen in label.keypoints_px
        if seen != KEYPOINT_OUTSIDE
    )
    return (
        f'<g class="label{" ignored" if label.ignore else ""}" style="--c:rgb({red},{green},{blue})">'
        f"<title>{escape(told)}{' (ignore region)' if label.ignore else ''}</title>"
        f'<path class="mask" d="{_mask_path(label.mask_rle, size_px)}"/>'
        f'<path class="amodal" d="{_box_path(label.amodal_box_whole_px)}"/>'
        f'<path class="box" d="{_box_path(label.box_px)}"/>'
        f'{corners}<text class="name" x="{x:.0f}" y="{y:.0f}">{escape(name)}</text></g>'
    )


def _box_path(box: BoxPx) -> str:
    x0, y0, x1, y1 = box
    return f"M{x0:.1f} {y0:.1f}H{x1:.1f}V{y1:.1f}H{x0:.1f}Z"


def _mask_path(runs: bytes, size_px: tuple[int, int]) -> str:
    """Return the outlines through the middles of a mask's outer pixels: drawn one pixel wide they cover the mask."""
    width, height = size_px
    mask = pycocotools.mask.decode({"size": [height, width], "counts": runs})
    outlines, _ = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    return "".join("M" + "L".join(f"{u + 0.5:g} {v + 0.5:g}" for u, v in outline[:, 0]) + "Z" for outline in outlines)


def _lane_line(line: LaneLine) -> str:
    """Return a line through its points, thin where something stands before them."""
    seen = line.visible
    parts = [_stretch(line, 0, len(seen), "lane hidden")]
    borders = np.flatnonzero(np.diff(seen.astype(np.int8), prepend=0, append=0))
    parts += [_stretch(line, int(first), int(end), "lane") for first, end in borders.reshape(-1, 2)]
    return f'<g class="lanes"><title>{escape(line.name)}</title>{"".join(parts)}</g>'


def _stretch(line: LaneLine, first: int, end: int, kind: str) -> str:
    points = " ".join(f"{u:.1f},{v:.1f}" for u, v in line.points_px[first:end].tolist())
    return f'<polyline class="{kind}" points="{points}"/>'
