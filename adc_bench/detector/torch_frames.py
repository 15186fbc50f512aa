"""A dataset's frames as torchvision's detection references want them, for any model that is trained so."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from pycocotools import mask as rle
from torch import Tensor
from torch.utils.data import Dataset

from adc_bench.dataset import FrameDataset
from adc_bench.detector.data import truth_arrays
from adc_bench.world.frame import KEYPOINT_VISIBLE, Label

Target = dict[str, Tensor]


class TorchFrames(Dataset[tuple[Tensor, Target]]):
    """(picture, target) by index; safe with any number of loader workers, forked or spawned.

    The picture is rgb (3, h, w) uint8. The target of m labels holds `boxes` (m, 4) xyxy px, `labels` (m,) category ids
    from 1, `keypoints` (m, 4, 3) u, v px and 1 if seen or else 0, `area` (m,) visible px, `iscrowd` (m,) 1 for a region
    to ignore, and `image_id`; with `masks` also `masks` (m, h, w) uint8, the visible pixels. Without `crowds` the
    regions to ignore are left out, as training with torchvision's models needs.
    """

    def __init__(self, source: FrameDataset | Path | str, *, masks: bool = False, crowds: bool = True) -> None:
        self.source = source if isinstance(source, FrameDataset) else FrameDataset(source)
        self._masks, self._crowds = masks, crowds

    def __len__(self) -> int:
        return len(self.source)

    def __getitem__(self, index: int) -> tuple[Tensor, Target]:
        picture = torch.from_numpy(np.ascontiguousarray(self.source.picture(index).transpose(2, 0, 1)))
        labels = [label for label in self.source.annotations(index) if self._crowds or not label.ignore]
        target = _target(index, labels)
        if self._masks:
            target["masks"] = _masks(labels, self.source.height_px, self.source.width_px)
        return picture, target


def collate_frames(batch: Sequence[tuple[Tensor, Target]]) -> tuple[Tensor, list[Target]]:
    """Return the pictures (n, 3, h, w) and their targets: a DataLoader's `collate_fn`."""
    return torch.stack([picture for picture, _ in batch]), [target for _, target in batch]


def _target(index: int, labels: Sequence[Label]) -> Target:
    boxes, classes, ignored = truth_arrays(labels)
    keypoints = np.array([label.keypoints_px for label in labels], dtype=np.float32).reshape(-1, 4, 3)
    keypoints[..., 2] = keypoints[..., 2] == KEYPOINT_VISIBLE
    return {
        "boxes": torch.from_numpy(boxes),
        "labels": torch.from_numpy(classes + 1),
        "keypoints": torch.from_numpy(keypoints),
        "image_id": torch.tensor(index),
        "area": torch.tensor([float(label.visible_px) for label in labels]),
        "iscrowd": torch.from_numpy(ignored.astype(np.int64)),
    }


def _masks(labels: Sequence[Label], height_px: int, width_px: int) -> Tensor:
    if not labels:
        return torch.zeros((0, height_px, width_px), dtype=torch.uint8)
    decoded = rle.decode([{"size": [height_px, width_px], "counts": label.mask_rle} for label in labels])
    return torch.from_numpy(np.ascontiguousarray(decoded.transpose(2, 0, 1)))
