"""Making more of a picture: with more signs and with stripes in it, mirrored, shifted, scaled, under other light."""

from collections.abc import Sequence

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.paste import Cutting, Example, paste_sign, paste_stripes
from adc_bench.world.categories import CATEGORIES

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


class AugmentConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How far a picture is changed: probabilities of a pasted sign (tried twice), of pasted stripes and of the mirror,
    largest zoom (in and out) as a factor, shift as a share of the picture, exposure in stops, gamma as a factor, white
    balance as a factor per channel, and the share of an object that must stay in view, and the smallest side in pixels
    that its box must have, for it to be learned rather than ignored.
    """

    paste: float = 0.5
    stripes: float = 0.5
    mirror: float = 0.5
    zoom: float = 1.4
    shift: float = 0.1
    exposure_ev: float = 0.7
    gamma: float = 1.3
    balance: float = 1.08
    kept_share: float = 0.4
    side_min_px: float = 4.0


def augment(config: AugmentConfig, example: Example, cuttings: Sequence[Cutting], rng: np.random.Generator) -> Example:
    """Return a changed copy, into which some of the `cuttings` may have been pasted."""
    example = example._replace(rgb=example.rgb.copy())
    if rng.random() < config.stripes:
        example = paste_stripes(example, rng)
    for cutting in cuttings:
        if rng.random() < config.paste:
            example = paste_sign(example, cutting, rng)
    if rng.random() < config.mirror:
        example = mirror(example)
    log_zoom, shift_x, shift_y = rng.uniform(-1, 1, size=3)
    light = rng.uniform(-1, 1, size=5)
    height, width, _ = example.rgb.shape
    shift_px = (config.shift * width * shift_x, config.shift * height * shift_y)
    example = zoom(example, config.zoom**log_zoom, shift_px, config.kept_share)
    too_small = (example.boxes[:, 2:] - example.boxes[:, :2]).min(axis=1, initial=np.inf) < config.side_min_px
    return relight(config, example._replace(ignored=example.ignored | too_small), light)


def mirror(example: Example) -> Example:
    """Return the picture mirrored left to right, classes with it; as it is if it shows what has no mirror image."""
    classes = _MIRROR_CLASS[example.classes]
    if (classes < 0).any():
        return example
    width = example.rgb.shape[1]
    boxes = example.boxes.copy()
    boxes[:, [0, 2]] = width - example.boxes[:, [2, 0]]
    keypoints = example.keypoints[:, [1, 0, 3, 2]]
    keypoints[..., 0] = np.where(keypoints[..., 2] > 0, width - keypoints[..., 0], 0)
    return Example(example.rgb[:, ::-1], boxes, classes, example.ignored, keypoints)


def zoom(example: Example, factor: float, shift_px: tuple[float, float], kept_share: float) -> Example:
    """Return the picture scaled about its centre and shifted, its mean colour beyond its edge.

    An object with less than `kept_share` of its box left becomes a region to ignore; one that left is dropped.
    """
    height, width, _ = example.rgb.shape
    offset = np.array(
        [(1 - factor) * width / 2 + shift_px[0], (1 - factor) * height / 2 + shift_px[1]], dtype=np.float32
    )
    # Pixel centres lie at whole numbers plus one half here, at whole numbers in OpenCV.
    half = (factor - 1) / 2
    matrix = np.array([[factor, 0, offset[0] + half], [0, factor, offset[1] + half]])
    rgb = np.ascontiguousarray(example.rgb)
    rgb = cv2.warpAffine(rgb, matrix, (width, height), borderValue=cv2.mean(rgb)).astype(np.uint8, copy=False)
    moved = example.boxes * np.float32(factor) + np.tile(offset, 2)
    clipped = np.clip(moved, 0, np.array([width, height, width, height], dtype=np.float32))
    share = _area(clipped) / np.maximum(_area(moved), 1e-6)
    stays = share > 0.01
    ignored = example.ignored | (share < kept_share)
    keypoints = example.keypoints.copy()
    keypoints[..., :2] = keypoints[..., :2] * np.float32(factor) + offset
    inside = ((keypoints[..., :2] >= 0) & (keypoints[..., :2] < (width, height))).all(axis=2) & (keypoints[..., 2] > 0)
    keypoints *= inside[..., None]
    return Example(rgb, clipped[stays], example.classes[stays], ignored[stays], keypoints[stays])


def relight(config: AugmentConfig, example: Example, draws: NDArray[np.float64]) -> Example:
    """Return the picture under another exposure, gamma and white balance, by `draws` (5,) in [-1, 1]."""
    gain = 2.0 ** (config.exposure_ev * draws[0]) * config.balance ** draws[2:]
    levels = (np.arange(256)[:, None] / 255 * gain) ** (config.gamma ** draws[1])
    table = np.clip(levels * 255 + 0.5, 0, 255).astype(np.uint8)
    rgb = cv2.LUT(np.ascontiguousarray(example.rgb), table[None]).astype(np.uint8, copy=False)
    return example._replace(rgb=rgb)


def _area(boxes: NDArray[np.float32]) -> NDArray[np.float32]:
    size: NDArray[np.float32] = (boxes[:, 2:] - boxes[:, :2]).prod(axis=1)
    return size
