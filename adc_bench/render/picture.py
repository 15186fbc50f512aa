"""From the renderer's picture to the delivered one: sensor noise, then JPEG, the same for data and for driving."""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.world.streams import stream

JPEG_QUALITY = 92
NOISE_LEVELS = 8
_SLACK_PX = 64


def deliver(rgba: NDArray[np.uint8], noise_sd: float, rng: np.random.Generator) -> bytes:
    """Return the JPEG of a picture (h, w, 4) uint8 with sensor noise of the given standard deviation added."""
    height, width = rgba.shape[:2]
    brighter, darker = _noise_tiles(height, width, round(float(np.clip(noise_sd, 0, NOISE_LEVELS - 1))))
    y, x = rng.integers(0, _SLACK_PX, 2)
    window = np.s_[y : y + height, x : x + width]
    bgr = cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR)
    noisy = cv2.subtract(cv2.add(bgr, brighter[window]), darker[window])
    done, jpeg = cv2.imencode(".jpg", noisy, (cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY))
    assert done
    return jpeg.tobytes()


@lru_cache(maxsize=2 * NOISE_LEVELS)
def _noise_tiles(height: int, width: int, sd: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the positive and the negative part of a tile of noise in bgr, larger than the picture.

    A frame takes a window of it at a place drawn for the frame. In two parts, because adding signed to unsigned
    pixels costs ten times as much.
    """
    rng = stream(sd, "sensor noise")
    noise = np.round(rng.standard_normal((height + _SLACK_PX, width + _SLACK_PX, 3), dtype=np.float32) * sd)
    noise = np.ascontiguousarray(noise[..., ::-1])
    return np.clip(noise, 0, 255).astype(np.uint8), np.clip(-noise, 0, 255).astype(np.uint8)
