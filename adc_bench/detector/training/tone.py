"""Pictures taken otherwise: under other light, shaken, out of focus, with more noise. What is where stays the same."""

from functools import lru_cache

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.world.streams import stream

Picture = NDArray[np.uint8]
_MARGIN_PX, _DEVIATION = 64, 32.0


class ToneConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How often a picture is changed, and how far at most.

    `light`: exposure in stops, gamma, contrast and white balance per channel as factors. `motion`: a blur along a line
    of `motion_px`. `defocus`: a Gaussian blur. `noise`: Gaussian noise of a deviation in grey levels.
    """

    light: float = 0.9
    exposure_ev: float = 0.7
    gamma: float = 1.3
    contrast: float = 1.25
    balance: float = 1.08
    motion: float = 0.15
    motion_px: float = 7.0
    defocus: float = 0.1
    defocus_px: float = 1.2
    noise: float = 0.3
    noise_levels: float = 8.0


def retone(config: ToneConfig, rgb: Picture, rng: np.random.Generator) -> Picture:
    """Return the picture (h, w, 3) as another exposure would have shown it."""
    motion, defocus, light, noise = rng.random(4) < (config.motion, config.defocus, config.light, config.noise)
    if motion:
        rgb = shake(rgb, rng.uniform(1, config.motion_px), rng.uniform(0, np.pi))
    if defocus:
        rgb = _picture(cv2.GaussianBlur(rgb, (0, 0), rng.uniform(0.3, config.defocus_px)))
    if light:
        rgb = relight(config, rgb, rng.uniform(-1, 1, size=6))
    if noise:
        rgb = add_noise(rgb, rng.uniform(0, config.noise_levels), rng)
    return rgb


def relight(config: ToneConfig, rgb: Picture, draws: NDArray[np.float64]) -> Picture:
    """Return the picture under another exposure, gamma, contrast and white balance, by `draws` (6,) in [-1, 1].

    Contrast is about the picture's own mean.
    """
    gain = 2.0 ** (config.exposure_ev * draws[0]) * config.balance ** draws[3:]
    spread = config.contrast ** draws[2]
    mean = np.mean(cv2.mean(rgb)[:3]) / 255
    levels = np.clip((np.arange(256) / 255 - mean) * spread + mean, 0, 1)
    table = (levels[:, None] * gain) ** (config.gamma ** draws[1])
    return _picture(cv2.LUT(rgb, np.clip(table * 255 + 0.5, 0, 255).astype(np.uint8)[None]))


def shake(rgb: Picture, length_px: float, angle_rad: float) -> Picture:
    """Return the picture blurred along a line of `length_px` through each pixel."""
    reach = int(np.ceil(length_px / 2))
    along = np.linspace(-length_px / 2, length_px / 2, 8 * reach + 1)
    u, v = (np.rint(along * part).astype(int) + reach for part in (np.cos(angle_rad), np.sin(angle_rad)))
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1), np.float32)
    np.add.at(kernel, (v, u), np.float32(1 / len(along)))
    return _picture(cv2.filter2D(rgb, -1, kernel))


def add_noise(rgb: Picture, deviation: float, rng: np.random.Generator) -> Picture:
    """Return the picture with Gaussian noise of a deviation in grey levels: a part of one large sheet of noise."""
    height, width, _ = rgb.shape
    x, y = rng.integers(0, _MARGIN_PX, size=2)
    noise = _noise_sheet(height, width)[y : y + height, x : x + width]
    return _picture(cv2.addWeighted(rgb, 1.0, noise, deviation / _DEVIATION, 0.0, dtype=cv2.CV_8U))


@lru_cache(maxsize=2)
def _noise_sheet(height: int, width: int) -> NDArray[np.float32]:
    """Return noise for pictures (h, w, 3), larger by a margin, so that no two pictures need to get the same."""
    shape = (height + _MARGIN_PX, width + _MARGIN_PX, 3)
    return stream(0, "noise sheet", height, width).standard_normal(shape, np.float32) * np.float32(_DEVIATION)


def _picture(values: object) -> Picture:
    """Return what OpenCV made of a picture, which its types do not promise to be one."""
    return np.asarray(values, np.uint8)
