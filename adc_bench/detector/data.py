"""What the detector learns from and is scored on: pictures with labels, and the labels as arrays."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
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
