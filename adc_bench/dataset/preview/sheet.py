"""A contact sheet: pictures of every camera at every light level and in the tunnel, with their boxes."""

from collections import defaultdict
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.preview.colours import colour_of
from adc_bench.dataset.read import FrameDataset
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Label
from adc_bench.world.look import LIGHT_LEVELS

Picture = NDArray[np.uint8]
ROWS = (*LIGHT_LEVELS, "tunnel")


def contact_sheet(dataset: FrameDataset, per_camera: int = 3) -> Picture:
    """Return an rgb sheet: a row for each light level and one for the tunnel, `per_camera` pictures of each camera.

    In each group pictures with many boxes come first; a group without pictures leaves its places black.
    """
    cameras = [mount.name for mount in dataset.manifest.cameras]
    groups = _groups(dataset)
    blank = np.zeros((dataset.height_px, dataset.width_px, 3), dtype=np.uint8)
    rows = []
    for row in ROWS:
        cells = []
        for camera in cameras:
            chosen = _spread(dataset, groups[row, camera], per_camera)
            cells += [_cell(dataset, i) for i in chosen] + [blank] * (per_camera - len(chosen))
        rows.append(np.concatenate(cells, axis=1))
    return np.concatenate(rows, axis=0)


def draw_labels(picture: Picture, labels: Sequence[Label]) -> Picture:
    """Return a copy of the rgb picture with the labels' boxes and names; ignore regions in grey."""
    canvas = picture.copy()
    for label in labels:
        name = CATEGORIES[label.category_id - 1]
        colour = colour_of(name, ignored=label.ignore)
        x0, y0, x1, y1 = (round(value) for value in label.box_px)
        cv2.rectangle(canvas, (x0, y0), (x1 - 1, y1 - 1), colour, 1)
        _write(canvas, name, (x0 + 1, max(y0 - 3, 10)), colour)
    return canvas


def _groups(dataset: FrameDataset) -> dict[tuple[str, str], list[int]]:
    groups: dict[tuple[str, str], list[int]] = defaultdict(list)
    for i in range(len(dataset)):
        conditions = dataset.conditions(i)
        row = "tunnel" if conditions.in_tunnel else conditions.light_level
        groups[row, dataset.camera(i)].append(i)
    return groups


def _spread(dataset: FrameDataset, frames: list[int], count: int) -> list[int]:
    """Return up to `count` frames, from different scenarios first, those with the most boxes first."""
    by_boxes = sorted(frames, key=lambda i: (-sum(not label.ignore for label in dataset.annotations(i)), i))
    seen: dict[str, int] = defaultdict(int)
    ranked: list[tuple[int, int, int]] = []
    for i in by_boxes:
        scenario = dataset.conditions(i).scenario
        ranked.append((seen[scenario], len(ranked), i))
        seen[scenario] += 1
    return [i for _, _, i in sorted(ranked)[:count]]


def _cell(dataset: FrameDataset, i: int) -> Picture:
    canvas = draw_labels(dataset.picture(i), dataset.annotations(i))
    conditions = dataset.conditions(i)
    caption = f"{i} {dataset.camera(i)} {conditions.light_level}{' tunnel' if conditions.in_tunnel else ''}"
    _write(canvas, caption, (4, dataset.height_px - 6), (255, 255, 255))
    return canvas


def _write(canvas: Picture, text: str, at: tuple[int, int], colour: tuple[int, int, int]) -> None:
    u, v = at
    for x, y in ((u - 1, v), (u + 1, v), (u, v - 1), (u, v + 1)):
        cv2.putText(canvas, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (0, 0, 0), 1, cv2.LINE_AA)
    cv2.putText(canvas, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv2.LINE_AA)
