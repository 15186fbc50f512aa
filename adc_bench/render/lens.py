"""From the pinhole picture that the rasteriser draws to the one the lens throws on the sensor."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from cv2.typing import MatLike
from numpy.typing import NDArray

from adc_bench.geometry import Camera
from adc_bench.render.motion_blur import Flow

TAP_STEP = 1 / 160  # of the width between two taps of a blur, at most, where three are enough: 2 px of 320
Picture = NDArray[np.uint8]


class Warp:
    """Moves the pixels of a pinhole picture to where the camera's lens shows them; the map is computed once."""

    def __init__(self, camera: Camera, pinhole: Camera) -> None:
        """`pinhole` is the camera the pictures come from (`camera.covering_pinhole()`)."""
        u, v = np.meshgrid(np.arange(camera.width_px) + 0.5, np.arange(camera.height_px) + 0.5)
        source = pinhole.project(camera.rays(np.column_stack([u.ravel(), v.ravel()])))
        self._is_plain = camera == pinhole
        # Where each pixel comes from, u and v (2, h, w); OpenCV counts from the first pixel's centre.
        self._source = np.ascontiguousarray((source - 0.5).T.reshape(2, *u.shape), np.float32)
        self._grid = np.array([u - 0.5, v - 0.5], np.float32)
        self._to_nearest: tuple[NDArray[np.intp], NDArray[np.float32]] | None = None

    def colour(self, picture: Picture, flow: Flow | None) -> Picture:
        """Return the picture (h, w, 4) behind the lens, blurred along the flow if there is one."""
        sharp = picture if self._is_plain else _remap(picture, self._source, cv2.INTER_LINEAR)
        return sharp if flow is None else self._blurred(sharp, flow)

    def affine(self, picture: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return a picture (h, w) that is affine on every flat surface, as inverse depth is, behind the lens.

        A pixel's value is its nearest sample, moved to its centre along the surface's slope: no two surfaces mix.
        """
        if self._is_plain:
            return picture
        index, (by_u, by_v) = self._nearest(picture.shape[0], picture.shape[1])
        slope_u, slope_v = _slope(picture, 1).take(index), _slope(picture, 0).take(index)
        return np.asarray(picture.take(index) + by_u * slope_u + by_v * slope_v, np.float32)

    def ids(self, ids: Picture) -> Picture:
        """Return label ids (h, w) behind the lens: each pixel's is its centre's."""
        return ids if self._is_plain else _remap(ids, self._source, cv2.INTER_NEAREST)

    def _nearest(self, height: int, width: int) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
        """Return each pixel's nearest sample, counted row by row (h, w), and its way from there (2, h, w)."""
        if self._to_nearest is None:
            u, v = np.rint(self._source)
            u, v = np.clip(u, 0, width - 1), np.clip(v, 0, height - 1)
            away = np.asarray(self._source - np.stack([u, v]), np.float32)
            self._to_nearest = v.astype(np.intp) * width + u.astype(np.intp), away
        return self._to_nearest

    def _blurred(self, sharp: Picture, flow: Flow) -> Picture:
        """Return the mean of taps spread evenly over the exposure: three, or nine as three means of three taps each."""
        if flow.longest_px > 3 * TAP_STEP * sharp.shape[1]:
            sharp = self._three_taps(sharp, flow, 1 / 9, cv2.INTER_NEAREST)
        return self._three_taps(sharp, flow, 1 / 3, cv2.INTER_LINEAR)

    def _three_taps(self, picture: Picture, flow: Flow, step: float, interpolation: int) -> Picture:
        """Return the mean of the picture and of it moved by a share of the flow, there and back."""
        moved = [cv2.scaleAdd(flow.shift_px, time, self._grid) for time in (step, -step)]
        return _mean([picture, *(_remap(picture, source, interpolation) for source in moved)])


def _mean(pictures: Sequence[Picture]) -> Picture:
    """Return what pictures (h, w, 4) make together.

    Light adds up in squares of the picture's values: gamma 2 in place of 2.2, near enough for a mean.
    """
    height, width, channels = pictures[0].shape
    total = np.zeros((height, width * channels), np.float32)
    for picture in pictures:
        cv2.accumulateSquare(picture.reshape(total.shape), total)
    mean = cv2.convertScaleAbs(cv2.sqrt(total), alpha=1 / math.sqrt(len(pictures)))
    return np.asarray(mean.reshape(height, width, channels), np.uint8)


def _slope(picture: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Return the change (h, w) from pixel to pixel: the smaller one of both sides, none on a ridge."""
    lines = picture if axis == 0 else picture.T
    steps = lines[1:] - lines[:-1]
    before, after = np.concatenate([steps[:1], steps]), np.concatenate([steps, steps[-1:]])
    slope = np.maximum(np.minimum(before, after), 0) + np.minimum(np.maximum(before, after), 0)
    return slope if axis == 0 else np.ascontiguousarray(slope.T)


def _remap(picture: Picture, source: MatLike, interpolation: int) -> Picture:
    u, v = source
    return np.asarray(cv2.remap(picture, u, v, interpolation, borderMode=cv2.BORDER_REPLICATE), np.uint8)
