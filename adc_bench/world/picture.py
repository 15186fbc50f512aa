"""The one way from a delivered picture's bytes to its pixels: the detector trains and the driver drives on the same."""

import cv2
import numpy as np
from numpy.typing import NDArray


def decode_picture(data: bytes) -> NDArray[np.uint8] | None:
    """Return the picture (a JPEG, or a PNG) as rgb, (height, width, 3) uint8; None if the bytes are no picture."""
    bgr = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR) if data else None
    return None if bgr is None else np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), dtype=np.uint8)
