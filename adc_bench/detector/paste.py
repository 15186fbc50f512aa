"""Things put into a picture where nothing is labelled: signs to be found, stripes to be left alone."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray


class Example(NamedTuple):
    """A picture with its truth: rgb (h, w, 3), boxes (m, 4) xyxy px, classes (m,) counted from 0, ignored (m,)."""

    rgb: NDArray[np.uint8]
    boxes: NDArray[np.float32]
    classes: NDArray[np.int64]
    ignored: NDArray[np.bool_]


class Cutting(NamedTuple):
    """A sign cut from a picture: rgb (h, w, 3) and its class, counted from 0."""

    rgb: NDArray[np.uint8]
    category: int


def paste_sign(example: Example, cutting: Cutting, rng: np.random.Generator) -> Example:
    """Return the example with a sign, 16 to 90 px wide, pasted in where nothing is labelled, unless the place drawn is
    taken. Draws into the example's picture.
    """
    sign_height, sign_width, _ = cutting.rgb.shape
    width = round(float(np.exp(rng.uniform(np.log(16), np.log(90)))))
    height = max(round(sign_height * width / sign_width), 1)
    place = _free_place(example, width, height, rng)
    if place is None:
        return example
    x, y = place
    example.rgb[y : y + height, x : x + width] = cv2.resize(
        cutting.rgb, (width, height), interpolation=cv2.INTER_AREA if width < sign_width else cv2.INTER_LINEAR
    )
    box = np.array([[x, y, x + width, y + height]], dtype=np.float32)
    return Example(
        example.rgb,
        np.concatenate([example.boxes, box]),
        np.append(example.classes, cutting.category),
        np.append(example.ignored, False),
    )


def paste_stripes(example: Example, rng: np.random.Generator) -> Example:
    """Return the example with a striped patch where nothing is labelled: stripes alone are no crosswalk. Draws into the
    example's picture.
    """
    full_height, full_width, _ = example.rgb.shape
    width, height = int(rng.integers(20, full_width * 2 // 3)), int(rng.integers(12, full_height // 2))
    period, angle, share = rng.uniform(5, 50), rng.uniform(0, np.pi), rng.uniform(0.25, 0.75)
    colours = rng.integers(0, 256, size=(2, 3)) * rng.uniform(0.2, 1.0)
    place = _free_place(example, width, height, rng)
    if place is None:
        return example
    x, y = place
    across = np.arange(width) * np.cos(angle) + np.arange(height)[:, None] * np.sin(angle)
    light = (across / period % 1 < share)[..., None]
    example.rgb[y : y + height, x : x + width] = np.where(light, *colours)
    return example


def _free_place(example: Example, width: int, height: int, rng: np.random.Generator) -> tuple[int, int] | None:
    full_height, full_width, _ = example.rgb.shape
    x, y = int(rng.integers(0, max(full_width - width, 1))), int(rng.integers(0, max(full_height - height, 1)))
    apart = (
        (example.boxes[:, 0] >= x + width)
        | (example.boxes[:, 2] <= x)
        | (example.boxes[:, 1] >= y + height)
        | (example.boxes[:, 3] <= y)
    )
    fits = width <= full_width and height <= full_height
    return (x, y) if fits and bool(apart.all()) else None
