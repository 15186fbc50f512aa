"""The frames as torchvision's detection references want them, through loaders with and without worker processes."""

import multiprocessing

import numpy as np
import pytest
import torch
from pycocotools import mask as rle
from torch import Tensor
from torch.utils.data import DataLoader
from torchvision.models.detection import KeypointRCNN
from torchvision.models.detection.backbone_utils import resnet_fpn_backbone

from adc_bench.dataset import FrameDataset
from adc_bench.detector.torch_frames import Target, TorchFrames, collate_frames
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import KEYPOINT_VISIBLE

Batches = list[tuple[Tensor, list[Target]]]


def batches(frames: TorchFrames, workers: int, context: str | None = None) -> Batches:
    loader = DataLoader(
        frames, batch_size=16, collate_fn=collate_frames, num_workers=workers, multiprocessing_context=context
    )
    return list(loader)


def test_targets_repeat_the_labels(training: FrameDataset) -> None:
    frames = TorchFrames(training, masks=True)
    assert len(frames) == len(training)
    for i in range(len(frames)):
        picture, target = frames[i]
        labels = training.annotations(i)
        assert picture.dtype == torch.uint8 and picture.shape == (3, 120, 160)
        assert np.array_equal(picture.numpy().transpose(1, 2, 0), training.picture(i))
        assert target["boxes"].shape == (len(labels), 4)
        assert target["boxes"].tolist() == [list(label.box_px) for label in labels]
        assert target["labels"].tolist() == [label.category_id for label in labels]
        assert target["iscrowd"].tolist() == [label.ignore for label in labels]
        assert target["area"].tolist() == [label.visible_px for label in labels]
        assert target["image_id"].item() == i
        assert target["keypoints"].shape == (len(labels), 4, 3)
        seen = [[point[2] == KEYPOINT_VISIBLE for point in label.keypoints_px] for label in labels]
        assert target["keypoints"][..., 2].tolist() == seen


def test_masks_are_those_of_the_labels(training: FrameDataset) -> None:
    frames = TorchFrames(training, masks=True)
    for i in range(len(frames)):
        masks, labels = frames[i][1]["masks"], training.annotations(i)
        assert masks.shape == (len(labels), 120, 160) and masks.dtype == torch.uint8
        assert masks.sum(dim=(1, 2)).tolist() == [label.visible_px for label in labels]
        for mask, label in zip(masks.numpy(), labels, strict=True):
            assert np.array_equal(mask, rle.decode({"size": [120, 160], "counts": label.mask_rle}))


def test_regions_to_ignore_can_be_left_out(training: FrameDataset) -> None:
    whole, counted = TorchFrames(training), TorchFrames(training, crowds=False)
    ignored = sum(int(whole[i][1]["iscrowd"].sum()) for i in range(len(whole)))
    assert ignored > 0
    assert not any(counted[i][1]["iscrowd"].any() for i in range(len(counted)))
    boxes = [sum(len(frames[i][1]["boxes"]) for i in range(len(frames))) for frames in (whole, counted)]
    assert boxes[0] - boxes[1] == ignored


@pytest.mark.parametrize(("workers", "context"), [(2, "fork"), (2, "spawn")])
def test_worker_processes_give_the_same_batches(training: FrameDataset, workers: int, context: str) -> None:
    assert context in multiprocessing.get_all_start_methods()
    frames = TorchFrames(training.store.root, masks=True)
    frames[0]  # what was read before the fork must not be shared with it
    here, there = batches(frames, 0), batches(frames, workers, context)
    assert sum(len(pictures) for pictures, _ in here) == len(training)
    for (pictures, targets), (others, other_targets) in zip(here, there, strict=True):
        assert torch.equal(pictures, others)
        for one, other in zip(targets, other_targets, strict=True):
            assert one.keys() == other.keys() and all(torch.equal(one[name], other[name]) for name in one)


def test_a_model_of_torchvision_learns_from_them(training: FrameDataset) -> None:
    frames = TorchFrames(training, crowds=False)
    chosen = [i for i in range(len(frames)) if len(frames[i][1]["boxes"])][:2]
    pictures, targets = collate_frames([frames[i] for i in chosen])
    backbone = resnet_fpn_backbone(backbone_name="resnet18", weights=None)
    model = KeypointRCNN(backbone, num_classes=len(CATEGORIES) + 1, num_keypoints=4, min_size=120, max_size=160)
    losses = model(list(pictures / 255), targets)
    total = sum(losses.values())
    assert torch.isfinite(total)
    total.backward()
