"""What a picture of ids says about each id: box, pixels and mask, all from its runs down the columns."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import cv2
import numpy as np
import pycocotools.mask
from numpy.typing import NDArray

from adc_bench.world.frame import BoxPx

Ids = NDArray[np.uint8]
Integers = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Region:
    """The pixels of one id.

    Attributes:
        box_px: tight around them; borders, not centres.
        mask_rle: COCO's compressed run lengths, equal to `pycocotools.mask.encode` of the mask.
    """

    box_px: BoxPx
    visible_px: int
    mask_rle: bytes


@dataclass(frozen=True, kw_only=True, eq=False)
class _Runs:
    """Stretches of one id down the columns, (n,): the first pixel, the one after the last, and the id."""

    starts: Integers
    ends: Integers
    ids: Ids

    @classmethod
    def of(cls, picture: Ids, wanted: Collection[int]) -> "_Runs":
        """Return the runs of the wanted ids, by id, then by place."""
        pixels = cv2.transpose(picture).ravel()
        borders = np.flatnonzero(pixels[1:] != pixels[:-1]) + 1
        starts, ends = np.concatenate([[0], borders]), np.append(borders, pixels.size)
        ids = pixels[starts]
        is_wanted = np.zeros(256, np.bool_)
        is_wanted[list(wanted)] = True
        some = np.flatnonzero(is_wanted[ids])
        order = some[np.argsort(ids[some], kind="stable")]
        return cls(starts=starts[order], ends=ends[order], ids=ids[order])


def regions(picture: Ids, wanted: Collection[int]) -> Mapping[int, Region]:
    """Return the region of each wanted id that has a pixel in the picture (h, w), in the order of ids."""
    runs = _Runs.of(picture, wanted)
    if not len(runs.ids):
        return {}
    first = np.flatnonzero(np.diff(runs.ids, prepend=-1))
    boxes, masks = _boxes(runs, first, len(picture)), _masks(runs, first, picture.shape)
    counts = np.add.reduceat(runs.ends - runs.starts, first)
    each = zip(runs.ids[first].tolist(), boxes, counts.tolist(), masks, strict=True)
    return {label_id: Region(box_px=box, visible_px=px, mask_rle=mask) for label_id, box, px, mask in each}


def _boxes(runs: _Runs, first: Integers, height: int) -> list[BoxPx]:
    left, right = runs.starts // height, (runs.ends - 1) // height + 1
    several = right - left > 1  # a run over several columns reaches from top to foot
    top = np.minimum.reduceat(np.where(several, 0, runs.starts - left * height), first)
    foot = np.maximum.reduceat(np.where(several, height, runs.ends - left * height), first)
    last = np.append(first[1:], len(left)) - 1
    x0, y0, x1, y1 = (edge.astype(float).tolist() for edge in (left[first], top, right[last], foot))
    return list(zip(x0, y0, x1, y1, strict=True))


def _masks(runs: _Runs, first: Integers, shape: tuple[int, ...]) -> list[bytes]:
    before = np.concatenate([[0], runs.ends[:-1]])
    before[first] = 0
    lengths = np.column_stack([runs.starts - before, runs.ends - runs.starts]).ravel()
    ends = np.append(first[1:], len(runs.ids))
    rests = shape[0] * shape[1] - runs.ends[ends - 1]  # what is left of the picture below and behind an id's last run
    closed, size = np.insert(lengths, 2 * ends, rests).astype(np.uint32), [shape[0], shape[1]]
    borders, is_open = (2 * ends + np.arange(1, len(ends) + 1)).tolist(), (rests == 0).tolist()
    starts = [0, *borders[:-1]]
    plain = [
        {"counts": closed[start : border - full], "size": size}
        for start, border, full in zip(starts, borders, is_open, strict=True)
    ]
    return [packed["counts"] for packed in pycocotools.mask.frPyObjects(plain, *size)]
