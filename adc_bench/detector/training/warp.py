"""Pictures moved with all that is known of them: mirrored, scaled, shifted, turned, sheared, four put into one."""

from collections.abc import Sequence

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.training.example import Example
from adc_bench.world.categories import CATEGORIES

GONE_SHARE = 0.01  # an object of which less is left is no longer there

# What a category becomes in the mirror. One that is not here has no mirror image among the categories, so a picture
# that shows it is never mirrored.
MIRRORED = {
    "crosswalk": "crosswalk",
    "panel_up": "panel_up",
    "panel_left": "panel_right",
    "panel_right": "panel_left",
    "panel_stop": "panel_stop",
    "panel_end": "panel_end",
    "box": "box",
    "cone": "cone",
}
_MIRROR_CLASS = np.array([CATEGORIES.index(MIRRORED[name]) if name in MIRRORED else -1 for name in CATEGORIES])


class WarpConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How often a picture is moved, and how far at most: zoom (in and out) as a factor, shift as a share of the
    picture, turn about its centre as a rolling camera makes it, shear as a share of the height.
    """

    probability: float = 0.9
    zoom: float = 1.4
    shift: float = 0.1
    turn_rad: float = 0.06
    shear: float = 0.05


class KeptConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The share of an object that must stay in view, and the smallest side in pixels that its box must have, for it to
    be learned rather than ignored.
    """

    share: float = 0.4
    side_px: float = 4.0


def mirror(example: Example) -> Example:
    """Return the picture mirrored left to right, classes with it; as it is if it shows what has no mirror image."""
    classes = _MIRROR_CLASS[example.classes]
    if (classes < 0).any():
        return example
    width = example.rgb.shape[1]
    outlines, keypoints = example.outlines.copy(), example.keypoints[:, [1, 0, 3, 2]]
    outlines[..., 0] = width - outlines[..., 0]
    keypoints[..., 0] = np.where(keypoints[..., 2] > 0, width - keypoints[..., 0], 0)
    rgb = np.asarray(cv2.flip(example.rgb, 1), np.uint8)
    return Example(rgb, outlines, classes, example.ignored, keypoints)


def draw_matrix(config: WarpConfig, size_px: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a random affine map (2, 3) of points of a picture of `size_px` (width, height), about its centre."""
    zoom, turn, shear, *shift = rng.uniform(-1, 1, size=5)
    size = np.array(size_px, np.float64)
    factor, angle = config.zoom**zoom, config.turn_rad * turn
    cos, sin = factor * np.cos(angle), factor * np.sin(angle)
    linear = np.array([[cos, -sin], [sin, cos]]) @ np.array([[1, config.shear * shear], [0, 1]])
    offset = size / 2 + config.shift * size * shift - linear @ (size / 2)
    return np.column_stack([linear, offset])


def warp(kept: KeptConfig, example: Example, matrix: NDArray[np.float64], size_px: tuple[int, int]) -> Example:
    """Return the part of `size_px` (width, height) at the origin of the moved picture, its mean colour beyond its edge.

    An object with too little of its box left becomes a region to ignore; one that left is dropped.
    """
    linear, offset = matrix[:, :2], matrix[:, 2]
    # Pixel centres lie at whole numbers plus one half here, at whole numbers in OpenCV.
    opencv = np.column_stack([linear, offset + linear @ (0.5, 0.5) - 0.5])
    rgb = cv2.warpAffine(example.rgb, opencv, size_px, borderValue=cv2.mean(example.rgb)).astype(np.uint8, copy=False)
    moved = example.outlines @ linear.T + offset
    clipped = np.clip(moved, 0, size_px)
    share = _box_areas(clipped) / np.maximum(_box_areas(moved), 1e-6)
    at = example.keypoints[..., :2] @ linear.T + offset
    inside = ((at >= 0) & (at < size_px)).all(axis=2) & (example.keypoints[..., 2] > 0)
    keypoints = np.concatenate([at, example.keypoints[..., 2:]], axis=2) * inside[..., None]
    stays = share > GONE_SHARE
    return Example(
        rgb,
        clipped[stays].astype(np.float32),
        example.classes[stays],
        (example.ignored | (share < kept.share))[stays],
        keypoints[stays].astype(np.float32),
    )


def mosaic(kept: KeptConfig, tiles: Sequence[Example], rng: np.random.Generator) -> Example:
    """Return a picture of four parts, each filled by a part of one of four pictures, scaled down to at most the part.

    Parts meet at a point in the middle two fifths. All pictures have the size of the first.
    """
    height, width, _ = tiles[0].rgb.shape
    x, y = (round(float(side * rng.uniform(0.3, 0.7))) for side in (width, height))
    corners = [(0, 0, x, y), (x, 0, width, y), (0, y, x, height), (x, y, width, height)]
    rgb = np.empty_like(tiles[0].rgb)
    parts = []
    for tile, (x0, y0, x1, y1) in zip(tiles, corners, strict=True):
        least = max((x1 - x0) / width, (y1 - y0) / height)
        scale = rng.uniform(least, 1.0)
        offset = rng.uniform((x1 - x0 - scale * width, y1 - y0 - scale * height), 0.0)
        part = warp(kept, tile, np.column_stack([np.eye(2) * scale, offset]), (x1 - x0, y1 - y0))
        rgb[y0:y1, x0:x1] = part.rgb
        parts.append(_shifted(part, (x0, y0)))
    truth = zip(*(part[1:] for part in parts), strict=True)
    return Example(rgb, *(np.concatenate(arrays) for arrays in truth))


def _shifted(example: Example, by_px: tuple[int, int]) -> Example:
    keypoints = example.keypoints.copy()
    shift = np.array(by_px, np.float32)
    keypoints[..., :2] += shift * (keypoints[..., 2:] > 0)
    return example._replace(outlines=example.outlines + shift, keypoints=keypoints)


def _box_areas(outlines: NDArray[np.float64]) -> NDArray[np.float64]:
    areas: NDArray[np.float64] = (outlines.max(axis=1) - outlines.min(axis=1)).prod(axis=1)
    return areas
