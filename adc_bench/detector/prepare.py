"""From pictures to the network's input, the same in training and in driving."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

MULTIPLE_PX = 32  # the coarsest grid's stride
DEVIATION_FLOOR = 4.0  # grey levels; a picture of nothing but noise is not blown up to full contrast


def prepare(pictures: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
    """Return n pictures of one size (h, w, 3) as network input (n, 3, h', w').

    Each gets mean 0 and deviation about 1, so that the light's level matters little, and zeros at the bottom and the
    right up to multiples of `MULTIPLE_PX`.
    """
    height, width, _ = pictures[0].shape
    padded_height, padded_width = (side + -side % MULTIPLE_PX for side in (height, width))
    prepared = np.empty((len(pictures), 3, padded_height, padded_width), np.float32)
    prepared[:, :, height:] = prepared[:, :, :height, width:] = 0
    for rgb, planes in zip(pictures, prepared, strict=True):
        levels = _levels(rgb)
        for colour, plane in zip(cv2.split(rgb), planes, strict=True):
            cv2.LUT(colour, levels, dst=plane[:height, :width])
    return prepared


def _levels(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return what each grey level becomes, (256,)."""
    means, deviations = cv2.meanStdDev(rgb.reshape(len(rgb), -1))  # all colours in one row, as if of one colour
    return np.asarray((np.arange(256) - means[0]) / (deviations[0] + DEVIATION_FLOOR), np.float32)
