"""Things put into a picture where nothing is labelled: signs to be found, stripes to be left alone."""

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.training.example import Cutting, Example


def paste_sign(example: Example, cutting: Cutting, rng: np.random.Generator) -> Example:
    """Return the example with a sign, 10 to 90 px wide, pasted in where nothing is labelled, unless the place drawn is
    taken. Draws into the example's picture.
    """
    sign_height, sign_width, _ = cutting.rgb.shape
    width = round(float(np.exp(rng.uniform(np.log(10), np.log(90)))))
    height = max(round(sign_height * width / sign_width), 1)
    place = _free_place(example, width, height, rng)
    if place is None:
        return example
    x, y = place
    example.rgb[y : y + height, x : x + width] = cv2.resize(
        cutting.rgb, (width, height), interpolation=cv2.INTER_AREA if width < sign_width else cv2.INTER_LINEAR
    )
    scale, shift = np.array([[width / sign_width, height / sign_height], [x, y]], np.float32)
    keypoints = cutting.keypoints.copy()
    keypoints[:, :2] = (keypoints[:, :2] * scale + shift) * (keypoints[:, 2:] > 0)
    return Example(
        example.rgb,
        np.concatenate([example.outlines, (cutting.outline * scale + shift)[None]]),
        np.append(example.classes, cutting.category),
        np.append(example.ignored, False),
        np.concatenate([example.keypoints, keypoints[None]]),
    )


def paste_stripes(example: Example, rng: np.random.Generator) -> Example:
    """Return the example with a patch of stripes or checks behind what is labelled: stripes alone are no crosswalk.
    Draws into the example's picture.
    """
    full_height, full_width, _ = example.rgb.shape
    width, height = (
        int(rng.integers(full_width // 8, full_width)),
        int(rng.integers(full_height // 10, full_height // 2)),
    )
    x, y = int(rng.integers(0, full_width - width)), int(rng.integers(0, full_height - height))
    angle = rng.choice([0.0, np.pi / 2]) + rng.normal(0, 0.2)
    light = _stripes(width, height, angle, rng)
    if rng.random() < 0.3:
        light ^= _stripes(width, height, angle + np.pi / 2, rng)
    grey, tint = rng.uniform(0.1, 1.0, size=(2, 1)), rng.normal(0, rng.choice([0.05, 0.3]), size=(2, 3))
    colours = np.clip((grey + tint) * example.rgb.max(), 0, 255).astype(np.uint8)
    patch = example.rgb[y : y + height, x : x + width]
    before = patch.copy()
    patch[:] = colours[light.view(np.uint8)]
    for x0, y0, x1, y1 in np.round(example.boxes - np.array([x, y, x, y])).astype(int).clip(min=0):
        patch[y0:y1, x0:x1] = before[y0:y1, x0:x1]
    return example


def _stripes(width: int, height: int, angle: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return (height, width): where the light stripes of a pattern lie that runs into the distance to one side."""
    u, v = np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32)[:, None]
    period, share, phase = np.exp(rng.uniform(np.log(7), np.log(50))), rng.uniform(0.25, 0.75), rng.random()
    fade_u, fade_v = rng.uniform(-0.4, 0.4, size=2)
    nearness = 1 + np.float32(fade_u / width) * u + np.float32(fade_v / height) * v
    across = (u * np.float32(np.cos(angle)) + v * np.float32(np.sin(angle))) / (nearness * np.float32(period))
    light: NDArray[np.bool_] = (across + np.float32(phase)) % 1 < share
    return light


def _free_place(example: Example, width: int, height: int, rng: np.random.Generator) -> tuple[int, int] | None:
    full_height, full_width, _ = example.rgb.shape
    x, y = int(rng.integers(0, max(full_width - width, 1))), int(rng.integers(0, max(full_height - height, 1)))
    x0, y0, x1, y1 = example.boxes.T
    apart = (x0 >= x + width) | (x1 <= x) | (y0 >= y + height) | (y1 <= y)
    fits = width <= full_width and height <= full_height
    return (x, y) if fits and bool(apart.all()) else None
