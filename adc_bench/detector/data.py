"""What the detector learns from and is scored on: pictures with labels, and the labels as arrays."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.frame import Conditions, Label
from adc_bench.world.sensors import CameraMount


class LabelledPictures(Protocol):
    """What the detector needs of a dataset."""

    @property
    def image_ids(self) -> Sequence[int]:
        """The pictures' ids, one each."""
        ...

    def __len__(self) -> int: ...

    def picture(self, index: int, /) -> NDArray[np.uint8]:
        """Return the picture (h, w, 3)."""
        ...

    def annotations(self, index: int, /) -> Sequence[Label]:
        """Return what is to be seen on it."""
        ...

    def conditions(self, index: int, /) -> Conditions:
        """Return how it was taken."""
        ...

    def pose_world_camera(self, index: int, /) -> NDArray[np.float64]:
        """Return where the camera was, (4, 4)."""
        ...

    def pose_world_robot(self, index: int, /) -> Pose2:
        """Return where the robot stood."""
        ...

    def mount(self, index: int, /) -> CameraMount:
        """Return the camera, as it is said to sit on the robot."""
        ...


def truth_arrays(labels: Sequence[Label]) -> tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.bool_]]:
    """Return boxes (m, 4) xyxy px, classes (m,) counted from 0, ignored (m,)."""
    boxes = np.array([label.box_px for label in labels], dtype=np.float32).reshape(-1, 4)
    classes = np.array([label.category_id - 1 for label in labels], dtype=np.int64)
    return boxes, classes, np.array([label.ignore for label in labels], dtype=np.bool_)


def keypoints_as_seen(labels: Sequence[Label], pose_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return keypoints (m, 4, 3): u, v px and the state, from the top left clockwise as the camera, whose pose is
    (4, 4), sees them.

    A picture of the crosswalk alone does not say from which side of the course it is seen, so that its corners are
    told by near and far, left and right: of the order (-x -y, +x -y, +x +y, -x +y), far is +x for who looks towards +x.
    """
    keypoints = np.array([label.keypoints_px for label in labels], dtype=np.float32).reshape(-1, 4, 3)
    order = [2, 1, 0, 3] if pose_world_camera[0, 2] > 0 else [0, 3, 2, 1]
    crosswalks = [label.category_id == CATEGORY_ID["crosswalk"] for label in labels]
    keypoints[crosswalks] = keypoints[crosswalks][:, order]
    return keypoints
