"""A shard's label columns: values within limits, masks that agree with boxes, boxes that agree with each other."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pycocotools.mask
from numpy.typing import NDArray

from adc_bench.dataset.check.fault import Fault
from adc_bench.dataset.columns import Columns
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import KEYPOINT_HIDDEN, KEYPOINT_OUTSIDE, KEYPOINT_VISIBLE
from adc_bench.world.signs import SQUARES

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
ROUNDING = 1e-6
# A pixel belongs to what its centre shows, and the lens is drawn by taking the nearest pixel of an undistorted picture:
# each lets a mask stick out of the exact outline by half a pixel and more at a slant.
MASK_PX = 1.5
# What has its keypoints on its own outline; those of round and three-cornered signs lie around them.
OWN_CORNERS = [k for k, name in enumerate(CATEGORIES, 1) if name in SQUARES or name.startswith(("crosswalk", "panel"))]
KNOWN_VISIBILITIES = (KEYPOINT_OUTSIDE, KEYPOINT_HIDDEN, KEYPOINT_VISIBLE)


def label_faults(columns: Columns, size_px: tuple[int, int]) -> Iterator[Fault]:
    """Yield what is wrong with the labels of a shard whose pictures have this width and height."""
    rows = np.repeat(np.arange(len(columns["offset"]) - 1), np.diff(columns["offset"]))
    for text, wrong in _limits(columns, size_px):
        for k in np.flatnonzero(wrong):
            yield Fault(int(rows[k]), f"{_name(columns, k)}: {text}")
    yield from _mask_faults(columns, size_px)


def _name(columns: Columns, k: int | np.integer) -> str:
    instance: bytes = columns["instance"][k]
    return instance.decode(errors="replace")


def _limits(columns: Columns, size_px: tuple[int, int]) -> Iterator[tuple[str, Flags]]:
    """Yield each rule's text and where (n,) it is broken. A number that is none breaks every rule it is in."""
    box, amodal, whole = (columns[name] for name in ("box_px", "amodal_box_px", "amodal_box_whole_px"))
    category, quaternion = columns["category_id"], columns["pose_world_object"][:, 3:]
    yield "its category is unknown", ~((category >= 1) & (category <= len(CATEGORIES)))
    yield "its box is empty or leaves the picture", ~_proper(box, size_px)
    yield "its box has sides between pixels", _any(box != np.rint(box))
    yield "its amodal box is empty or leaves the picture", ~_proper(amodal, size_px)
    yield "its whole amodal box does not hold the amodal box", ~_holds(whole, amodal, 1.0)
    yield f"its box sticks out of its amodal box by more than {MASK_PX} px", ~_holds(amodal, box, MASK_PX)
    for field in ("visible_fraction", "truncation"):
        share = columns[field]
        yield f"its {field} lies outside 0..1", ~((share >= -ROUNDING) & (share <= 1 + ROUNDING))
    yield "its distance is not positive", ~((columns["distance_m"] > 0) & np.isfinite(columns["distance_m"]))
    yield "its pose has no unit quaternion", ~(np.abs(np.linalg.norm(quaternion, axis=1) - 1) < ROUNDING)
    yield "its place is not finite", _any(~np.isfinite(columns["pose_world_object"][:, :3]))
    yield from _keypoint_limits(columns["keypoints_px"], size_px)
    own = np.isin(category, OWN_CORNERS)[:, None] & (columns["keypoints_px"][..., 2] != KEYPOINT_OUTSIDE)
    places = columns["keypoints_px"][..., :2]
    around = (places >= whole[:, None, :2] - 1.0) & (places <= whole[:, None, 2:] + 1.0)
    yield "a keypoint lies outside its whole amodal box", _any(own[..., None] & ~around)


def _keypoint_limits(keypoints: Array, size_px: tuple[int, int]) -> Iterator[tuple[str, Flags]]:
    places, seen = keypoints[..., :2], keypoints[..., 2]
    outside = seen == KEYPOINT_OUTSIDE
    yield "a keypoint's visibility is unknown", _any(~np.isin(seen, KNOWN_VISIBILITIES))
    yield "a keypoint outside the picture is not at 0, 0", _any(outside[..., None] & (places != 0))
    yield "a keypoint leaves the picture", _any(~outside[..., None] & ~((places >= 0) & (places <= size_px)))


def _any(flags: Flags) -> Flags:
    """Return for each label whether any of its flags is up."""
    return np.asarray(flags.any(axis=tuple(range(1, flags.ndim))))


def _proper(box: Array, size_px: tuple[int, int]) -> Flags:
    outside = np.concatenate([box[:, :2] < -ROUNDING, box[:, 2:] > np.array(size_px) + ROUNDING], axis=1)
    return ~_any(outside) & ~_any(~(box[:, 2:] > box[:, :2]))


def _holds(outer: Array, inner: Array, tolerance_px: float) -> Flags:
    reach = np.concatenate([inner[:, :2] - outer[:, :2], outer[:, 2:] - inner[:, 2:]], axis=1)
    return ~_any(~(reach >= -tolerance_px))


def _mask_faults(columns: Columns, size_px: tuple[int, int]) -> Iterator[Fault]:
    """Decode each frame's masks: they must be pictures of the right size, disjoint, and as boxes and counts say."""
    width_px, height_px = size_px
    for row, (start, end) in enumerate(pairwise(columns["offset"].tolist())):
        if start == end:
            continue
        runs = [{"size": [height_px, width_px], "counts": bytes(columns["mask_rle"][k])} for k in range(start, end)]
        try:
            masks = pycocotools.mask.decode(runs)
        except (ValueError, TypeError):
            yield Fault(row, "a mask cannot be decoded")
            continue
        yield from _decoded_mask_faults(columns, row, start, masks)


def _decoded_mask_faults(columns: Columns, row: int, start: int, masks: NDArray[np.uint8]) -> Iterator[Fault]:
    if (masks.sum(axis=2, dtype=np.uint8) > 1).any():
        yield Fault(row, "masks of two objects overlap")
    across, down = np.asarray(masks.any(axis=0)), np.asarray(masks.any(axis=1))
    counts = masks.sum(axis=(0, 1), dtype=np.int64)
    for k in range(masks.shape[2]):
        name = _name(columns, start + k)
        if counts[k] != columns["visible_px"][start + k]:
            yield Fault(row, f"{name}: {counts[k]} pixels in its mask, visible_px {columns['visible_px'][start + k]}")
        if not counts[k]:
            continue
        u, v = np.flatnonzero(across[:, k]), np.flatnonzero(down[:, k])
        box = (u[0], v[0], u[-1] + 1, v[-1] + 1)
        if not np.array_equal(box, columns["box_px"][start + k]):
            yield Fault(row, f"{name}: its box is not the one around its mask")
