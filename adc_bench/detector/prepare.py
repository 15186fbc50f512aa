"""From a picture to the network's input, the same in training and in driving."""

import cv2
import numpy as np
from numpy.typing import NDArray

MULTIPLE_PX = 32  # the coarsest grid's stride
DEVIATION_FLOOR = 4.0  # grey levels; a picture of nothing but noise is not blown up to full contrast


def prepare(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return a picture (h, w, 3) as network input (3, h', w'): with mean 0 and deviation about 1, so that the light's
    level matters little, padded with zeros at the bottom and the right to multiples of `MULTIPLE_PX`.
    """
    height, width, _ = rgb.shape
    means, deviations = (values[:, 0] for values in cv2.meanStdDev(rgb))
    mean = float(means.mean())
    deviation = float(np.sqrt(np.mean(deviations**2 + (means - mean) ** 2)))
    padded = np.zeros((3, height + -height % MULTIPLE_PX, width + -width % MULTIPLE_PX), np.float32)
    scale = np.float32(1 / (deviation + DEVIATION_FLOOR))
    for channel, plane in zip(padded[:, :height, :width], cv2.split(rgb), strict=True):
        np.multiply(plane, scale, out=channel)
        channel -= np.float32(mean) * scale
    return padded
