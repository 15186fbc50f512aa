"""The corners of labelled objects as who sees them would name them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.frame import Label


def keypoints_as_seen(labels: Sequence[Label], *, towards_plus_x: bool) -> NDArray[np.float32]:
    """Return keypoints (m, 4, 3): u, v px and the state, from the top left clockwise as a camera sees them that looks
    towards +x of the world, or towards -x.

    A picture of the crosswalk alone does not say from which side of the course it is seen, so that its corners are
    told by near and far, left and right: of the order (-x -y, +x -y, +x +y, -x +y), far is +x for who looks towards +x.
    """
    keypoints = np.array([label.keypoints_px for label in labels], dtype=np.float32).reshape(-1, 4, 3)
    order = [2, 1, 0, 3] if towards_plus_x else [0, 3, 2, 1]
    crosswalks = [label.category_id == CATEGORY_ID["crosswalk"] for label in labels]
    keypoints[crosswalks] = keypoints[crosswalks][:, order]
    return keypoints
