"""A picture with its truth, and a sign cut from one, as training changes them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

# Directions in which an outline holds the outermost points: along the axes, and as far to either side as pictures turn.
_ANGLES_RAD = (np.arange(4)[:, None] * np.pi / 2 + np.radians(np.linspace(-6, 6, 9))).ravel()
DIRECTIONS = np.stack([np.cos(_ANGLES_RAD), np.sin(_ANGLES_RAD)])


class Example(NamedTuple):
    """A picture with m objects: rgb (h, w, 3), outlines (m, k, 2) px, classes (m,) counted from 0, ignored (m,), and
    keypoints (m, 4, 3): u, v px and the state (0 outside or none, 1 hidden, 2 seen), from the top left clockwise.

    An outline is the outermost points of what is seen of an object in `DIRECTIONS`: turned with the picture, it says
    how far the object reaches to each side, which its turned box would not.
    """

    rgb: NDArray[np.uint8]
    outlines: Array
    classes: NDArray[np.int64]
    ignored: NDArray[np.bool_]
    keypoints: Array

    @property
    def boxes(self) -> Array:
        """The boxes (m, 4) xyxy px around the outlines."""
        return np.concatenate([self.outlines.min(axis=1), self.outlines.max(axis=1)], axis=1)


class Cutting(NamedTuple):
    """A sign cut from a picture: rgb (h, w, 3), its class, counted from 0, its outline (k, 2) and its keypoints (4, 3)
    within `rgb`.
    """

    rgb: NDArray[np.uint8]
    category: int
    outline: Array
    keypoints: Array


def outline(mask: NDArray[np.uint8]) -> Array:
    """Return the outline (k, 2) of a mask (h, w) that is not empty: corners of its pixels."""
    rows = np.flatnonzero(mask.any(axis=1))
    seen = mask[rows] > 0
    left, right = seen.argmax(axis=1), mask.shape[1] - seen[:, ::-1].argmax(axis=1)
    corners = np.concatenate([np.stack([x, y], axis=1) for x in (left, right) for y in (rows, rows + 1)])
    outermost: Array = corners[(corners @ DIRECTIONS).argmax(axis=0)].astype(np.float32)
    return outermost
