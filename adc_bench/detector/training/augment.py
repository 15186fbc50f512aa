"""Making more of pictures: with more signs and with stripes in them, mirrored, moved, four in one, taken otherwise."""

from typing import Protocol

import msgspec
import numpy as np

from adc_bench.detector.training.example import Cutting, Example
from adc_bench.detector.training.paste import paste_sign, paste_stripes
from adc_bench.detector.training.tone import ToneConfig, retone
from adc_bench.detector.training.warp import KeptConfig, WarpConfig, draw_matrix, mirror, mosaic, warp


class AugmentConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a picture is changed: probabilities of a mosaic with three others, else of pasted stripes, of a pasted sign
    (tried twice) and of a warp; of the mirror in either case; and how it is taken.
    """

    mosaic: float = 0.3
    stripes: float = 0.5
    paste: float = 0.5
    mirror: float = 0.5
    warp: WarpConfig = WarpConfig()
    tone: ToneConfig = ToneConfig()
    kept: KeptConfig = KeptConfig()


class Supply(Protocol):
    """What goes into a picture beside its own content."""

    def example(self, rng: np.random.Generator, /) -> Example:
        """Return another picture."""
        ...

    def sign(self, rng: np.random.Generator, /) -> Cutting | None:
        """Return a sign to paste, None where there are none."""
        ...


def augment(
    config: AugmentConfig, example: Example, supply: Supply, rng: np.random.Generator, *, with_mosaic: bool
) -> Example:
    """Return a changed copy; without mosaics it is always of one picture."""
    if with_mosaic and rng.random() < config.mosaic:
        tiles = [_mirrored(config, tile, rng) for tile in (example, *(supply.example(rng) for _ in range(3)))]
        example = mosaic(config.kept, tiles, rng)
    else:
        example = _moved(config, _mirrored(config, _pasted(config, example, supply, rng), rng), rng)
    boxes = example.boxes
    too_small = (boxes[:, 2:] - boxes[:, :2]).min(axis=1, initial=np.inf) < config.kept.side_px
    return example._replace(rgb=retone(config.tone, example.rgb, rng), ignored=example.ignored | too_small)


def _pasted(config: AugmentConfig, example: Example, supply: Supply, rng: np.random.Generator) -> Example:
    example = example._replace(rgb=example.rgb.copy())
    if rng.random() < config.stripes:
        example = paste_stripes(example, rng)
    for _ in range(2):
        if rng.random() < config.paste and (sign := supply.sign(rng)):
            example = paste_sign(example, sign, rng)
    return example


def _mirrored(config: AugmentConfig, example: Example, rng: np.random.Generator) -> Example:
    return mirror(example) if rng.random() < config.mirror else example


def _moved(config: AugmentConfig, example: Example, rng: np.random.Generator) -> Example:
    if rng.random() >= config.warp.probability:
        return example
    height, width, _ = example.rgb.shape
    return warp(config.kept, example, draw_matrix(config.warp, (width, height), rng), (width, height))
