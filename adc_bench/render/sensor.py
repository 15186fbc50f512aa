"""The sensor: light lost towards the corners, noise that depends on the signal, and the file it delivers."""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.world.sensors import CameraMount, Imaging
from adc_bench.world.streams import stream

GAMMA = 2.2  # of our shader pack
# The noise is a product of whole numbers that fits 16 bits: standard deviations in sixteenths of a step, up to 15.9,
# times a tile of unit noise in parts of 32, cut off at 4 standard deviations.
SD_PARTS, SD_MAX, UNIT_PARTS, UNIT_MAX = 16, 255, 32, 4.0
SHIFT = 9  # 16 x 32
SLACK_PX = 64
Picture = NDArray[np.uint8]


class Sensor:
    """What one camera makes of the light that falls on it."""

    def __init__(self, mount: CameraMount) -> None:
        self._imaging = mount.imaging
        self._share = _corner_loss(mount.width_px, mount.height_px, mount.imaging.vignetting)

    def develop(self, rgba: Picture, gain: float, rng: np.random.Generator) -> Picture:
        """Return the delivered picture, bgr (h, w, 3), of the noiseless one (h, w, 4)."""
        bgr = np.asarray(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR), np.uint8)
        if self._imaging.vignetting:
            bgr = np.asarray(cv2.multiply(bgr, self._share, scale=1 / 255), np.uint8)
        if self._imaging.full_well_electrons:
            bgr = _noisy(bgr, noise_sd(gain, self._imaging), rng)
        return bgr

    def encode(self, bgr: Picture) -> bytes:
        """Return the file: a JPEG, or a PNG where no quality is given."""
        quality = self._imaging.jpeg_quality
        kind, options = (".png", ()) if quality is None else (".jpg", (cv2.IMWRITE_JPEG_QUALITY, quality))
        done, file = cv2.imencode(kind, bgr, options)
        assert done
        return file.tobytes()


def _corner_loss(width_px: int, height_px: int, loss: float) -> Picture:
    """Return the share of light that arrives, 255 for all, (h, w, 3), as it acts on gamma-coded values.

    It falls with the square of the distance from the middle, to 1 - loss in the corners.
    """
    u, v = np.meshgrid(np.arange(width_px) + 0.5 - width_px / 2, np.arange(height_px) + 0.5 - height_px / 2)
    square = (u**2 + v**2) / ((width_px**2 + height_px**2) / 4)
    share = np.round(255 * (1 - loss * square) ** (1 / GAMMA)).astype(np.uint8)
    return np.repeat(share[..., None], 3, axis=2)


def noise_sd(gain: float, imaging: Imaging) -> NDArray[np.float64]:
    """Return the noise's standard deviation, in steps of 255, of each of the 256 values a pixel can have.

    A signal s of full scale is n = s F / gain electrons of a full well of F; their number has the variance n (shot
    noise), and reading them adds r^2. In gamma-coded values this is half the way from one standard deviation below the
    signal to one above.
    """
    signal = (np.arange(256) / 255) ** GAMMA
    scale = gain / imaging.full_well_electrons
    sd = scale * np.sqrt(signal / scale + imaging.read_noise_electrons**2)
    coded: NDArray[np.float64] = 255 / 2 * ((signal + sd) ** (1 / GAMMA) - np.maximum(signal - sd, 0) ** (1 / GAMMA))
    return coded


def _noisy(bgr: Picture, sd: NDArray[np.float64], rng: np.random.Generator) -> Picture:
    height, width = bgr.shape[:2]
    y, x = rng.integers(0, SLACK_PX, 2)
    unit = _unit_noise(height, width)[y : y + height, x : x + width]
    table = np.minimum(np.round(sd * SD_PARTS), SD_MAX).astype(np.int16)
    noise: NDArray[np.int16] = np.asarray(cv2.LUT(bgr, table), np.int16) * unit
    noise += 1 << (SHIFT - 1)
    noise >>= SHIFT
    # whole numbers of 8 bits with a sign, which values are too with 128 taken away, add up fastest
    signed = (bgr ^ np.uint8(128)).view(np.int8)
    return np.asarray(cv2.add(signed, noise.astype(np.int8), dst=signed), np.int8).view(np.uint8) ^ np.uint8(128)


@lru_cache(maxsize=4)
def _unit_noise(height: int, width: int) -> NDArray[np.int16]:
    """Return a tile of noise, larger than the picture: a picture takes a window of it at a place of its own."""
    noise = stream(0, "sensor noise").standard_normal((height + SLACK_PX, width + SLACK_PX, 3), dtype=np.float32)
    return np.round(np.clip(noise, -UNIT_MAX, UNIT_MAX) * UNIT_PARTS).astype(np.int16)
