"""The worst that a detector did, to look at: what it invented, what it missed, which corners it put far off."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.evaluation.circumstances import box_side_px
from adc_bench.detector.evaluation.corners import errors_px
from adc_bench.detector.evaluation.drawing import draw_corners, draw_found, draw_truth, window_around
from adc_bench.detector.evaluation.evaluation import Evaluation
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Label

SHOWN_WIDTH_PX = 320


class Mistake(NamedTuple):
    """A part of a picture (h, w, 3), and what is wrong there."""

    rgb: NDArray[np.uint8]
    told: str


def invented(evaluation: Evaluation, most: int) -> Iterator[Mistake]:
    """Yield the surest detections of nothing."""
    matches = evaluation.matches
    wrong = np.flatnonzero(matches.wrong(evaluation.threshold))
    for k in wrong[np.argsort(-matches.scores[wrong], kind="stable")][:most].tolist():
        index, box = int(matches.picture[k]), matches.boxes_px[k].tolist()
        other = _overlapped(evaluation.source.annotations(index), box)
        told = f"{CATEGORIES[matches.category_ids[k] - 1]} {matches.scores[k]:.2f}, where {other} is"
        yield Mistake(_crop(evaluation, index, box), f"{told}; {_place(evaluation, index)}")


def missed(evaluation: Evaluation, most: int) -> Iterator[Mistake]:
    """Yield the largest objects that were not found."""
    matches = evaluation.matches
    rows = np.flatnonzero(matches.asked & (matches.found_score() < evaluation.threshold))
    sides = np.array([box_side_px(matches.labels[k].box_px) for k in rows.tolist()])
    for k in rows[np.argsort(-sides, kind="stable")][:most].tolist():
        index, label = int(matches.label_picture[k]), matches.labels[k]
        score = float(matches.found_score()[k])
        told = (
            f"{CATEGORIES[label.category_id - 1]} at {label.distance_m:.1f} m, {label.visible_fraction:.0%} visible, "
            f"{f'found with {score:.2f} only' if score >= 0 else 'not found'}"
        )
        yield Mistake(_crop(evaluation, index, label.box_px), f"{told}; {_place(evaluation, index)}")


def misplaced(evaluation: Evaluation, most: int) -> Iterator[Mistake]:
    """Yield the objects found whose seen corners are furthest off."""
    matches, corners = evaluation.matches, evaluation.corners
    off = np.hypot(*np.moveaxis(errors_px(matches, corners), -1, 0)) * corners.seen
    for k in np.argsort(-off.max(axis=1, initial=0.0), kind="stable")[:most]:
        label, detection, seen = matches.labels[corners.label[k]], corners.detection[k], corners.seen[k]
        if not seen.any():
            return
        index, sigma = int(matches.label_picture[corners.label[k]]), matches.keypoint_sigma_px[detection]
        rgb = _crop(
            evaluation,
            index,
            label.box_px,
            (corners.true_px[k][seen], matches.keypoints_px[detection][seen]),
        )
        worst = int(np.argmax(off[k]))
        told = (
            f"{CATEGORIES[label.category_id - 1]} at {label.distance_m:.1f} m: a corner {off[k, worst]:.1f} px off, "
            f"said to be within {sigma[worst]:.1f} px"
        )
        yield Mistake(rgb, f"{told}; {_place(evaluation, index)}")


def _crop(
    evaluation: Evaluation,
    index: int,
    box_px: Sequence[float],
    corners: tuple[NDArray[np.float32], NDArray[np.float32]] | None = None,
) -> NDArray[np.uint8]:
    """Return the part of a picture around a box: with corners where they are given, else with truth and answers."""
    rgb = evaluation.source.picture(index)
    window = window_around(box_px, (rgb.shape[1], rgb.shape[0]), SHOWN_WIDTH_PX)
    canvas = window.show(rgb)
    if corners:
        draw_corners(canvas, window, *corners)
    else:
        draw_truth(canvas, window, evaluation.source.annotations(index), named=False)
        draw_found(canvas, window, evaluation.found[index], evaluation.threshold)
    return canvas


def _overlapped(labels: Sequence[Label], box_px: Sequence[float]) -> str:
    """Return the name of the label that a box overlaps most."""
    best, name = 0.0, "nothing"
    for label in labels:
        overlap = _overlap(label.box_px, box_px)
        if overlap > best:
            best, name = overlap, f"{CATEGORIES[label.category_id - 1]} (overlap {overlap:.2f})"
    return name


def _overlap(a: Sequence[float], b: Sequence[float]) -> float:
    """Return the intersection over the union of two boxes."""
    common = box_side_px((max(a[0], b[0]), max(a[1], b[1]), min(a[2], b[2]), min(a[3], b[3]))) ** 2
    return common / max(box_side_px(a) ** 2 + box_side_px(b) ** 2 - common, 1e-9)


def _place(evaluation: Evaluation, index: int) -> str:
    conditions, mount = evaluation.source.conditions(index), evaluation.source.mount(index)
    tunnel = ", in the tunnel" if conditions.in_tunnel else ""
    return f"picture {index}, {mount.name} camera, {conditions.light_level}{tunnel}"
