"""From the pinhole picture that the rasteriser draws to the one the lens throws on the sensor."""

import math

import cv2
import numpy as np
from cv2.typing import MatLike
from numpy.typing import NDArray

from adc_bench.geometry import Camera
from adc_bench.render.motion_blur import Flow

TAP_STEP_PX, TAPS_MAX = 2.0, 12
NO_SECOND_MAP = np.empty(0, np.float32)  # both coordinates stand in the first
Picture = NDArray[np.uint8]


class Warp:
    """Moves the pixels of a pinhole picture to where the camera's lens shows them; the map is computed once."""

    def __init__(self, camera: Camera, pinhole: Camera) -> None:
        """`pinhole` is the camera the pictures come from (`camera.covering_pinhole()`)."""
        u, v = np.meshgrid(np.arange(camera.width_px) + 0.5, np.arange(camera.height_px) + 0.5)
        source = pinhole.project(camera.rays(np.column_stack([u.ravel(), v.ravel()])))
        self._is_plain = camera == pinhole
        # OpenCV counts from the first pixel's centre
        self._source = (source - 0.5).astype(np.float32).reshape(*u.shape, 2)

    def colour(self, picture: Picture, flow: Flow | None) -> Picture:
        """Return the picture (h, w, 4) behind the lens, blurred along the flow if there is one."""
        sharp = picture if self._is_plain else _remap(picture, self._source, cv2.INTER_LINEAR)
        return sharp if flow is None else self._blurred(picture, sharp, flow)

    def ids(self, ids: Picture) -> Picture:
        """Return label ids (h, w) behind the lens: each pixel's is its centre's."""
        return ids if self._is_plain else _remap(ids, self._source, cv2.INTER_NEAREST)

    def _blurred(self, picture: Picture, sharp: Picture, flow: Flow) -> Picture:
        """Average taps spread evenly over the exposure, in the rows that blur.

        Light adds up in squares of the picture's values: gamma 2 in place of 2.2, near enough for an average.
        """
        rows = flow.rows
        source, shift = self._source[rows], flow.shift_px[rows]
        taps = min(TAPS_MAX, math.ceil(flow.longest_px / TAP_STEP_PX) + 1)
        total = np.zeros((source.shape[0], source.shape[1] * 4), np.float32)
        for k in range(taps):
            tap = _remap(picture, cv2.scaleAdd(shift, (k + 0.5) / taps - 0.5, source), cv2.INTER_LINEAR)
            cv2.accumulateSquare(tap.reshape(total.shape), total)
        blurred = sharp.copy()
        blurred[rows] = cv2.convertScaleAbs(cv2.sqrt(total / taps)).reshape(*source.shape[:2], 4)
        return blurred


def _remap(picture: Picture, source: MatLike, interpolation: int) -> Picture:
    moved = cv2.remap(picture, source, NO_SECOND_MAP, interpolation, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(moved, np.uint8)
