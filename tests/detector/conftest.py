from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from adc_bench.dataset import FrameDataset, load_split
from adc_bench.detector.model import ModelConfig
from adc_bench.detector.training.augment import AugmentConfig
from adc_bench.detector.training.recipe import Recipe, TrainConfig
from adc_bench.detector.training.tone import ToneConfig
from adc_bench.detector.training.warp import WarpConfig
from adc_bench.generate import render_split
from adc_bench.geometry import Pose2
from adc_bench.world.frame import Conditions, Label
from adc_bench.world.sensors import CameraMount

SMALL = ModelConfig(stem=16, widths=(24, 32, 48), depths=(0, 1, 0), neck=24, head=24)
PLAIN = AugmentConfig(
    mosaic=0.0,
    stripes=0.0,
    paste=0.0,
    mirror=0.0,
    warp=WarpConfig(probability=0.0),
    tone=ToneConfig(light=0.0, motion=0.0, defocus=0.0, noise=0.0),
)
QUICK = Recipe(
    train=TrainConfig(
        threads=1,
        epochs=3,
        plain_epochs=1,
        batch=8,
        validate_every=2,
        checkpoint_steps=2,
        warmup_steps=4,
        average_decay=0.9,
    ),
    model=SMALL,
)

UNCLIPPED = msgspec.structs.replace(
    QUICK, train=msgspec.structs.replace(QUICK.train, epochs=2, validate_every=1, gradient_norm_max=1e6)
)


@pytest.fixture(autouse=True)
def _one_thread() -> None:
    torch.set_num_threads(1)


@pytest.fixture(scope="session")
def train_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("detector") / "train"
    render_split(load_split("train"), root, count=40, size_px=(160, 120))
    return root


@pytest.fixture(scope="session")
def val_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("detector") / "val"
    render_split(load_split("val"), root, count=32, size_px=(160, 120))
    return root


@pytest.fixture(scope="session")
def training(train_folder: Path) -> FrameDataset:
    return FrameDataset(train_folder)


@pytest.fixture(scope="session")
def validation(val_folder: Path) -> FrameDataset:
    return FrameDataset(val_folder)


class Some:
    """Some pictures of a dataset."""

    def __init__(self, source: FrameDataset, indices: Sequence[int]) -> None:
        self.source, self.indices = source, indices
        self.image_ids = [source.image_ids[i] for i in indices]

    def __len__(self) -> int:
        return len(self.indices)

    def picture(self, index: int) -> NDArray[np.uint8]:
        return self.source.picture(self.indices[index])

    def annotations(self, index: int) -> Sequence[Label]:
        return self.source.annotations(self.indices[index])

    def conditions(self, index: int) -> Conditions:
        return self.source.conditions(self.indices[index])

    def pose_world_camera(self, index: int) -> NDArray[np.float64]:
        return self.source.pose_world_camera(self.indices[index])

    def pose_world_robot(self, index: int) -> Pose2:
        return self.source.pose_world_robot(self.indices[index])

    def mount(self, index: int) -> CameraMount:
        return self.source.mount(self.indices[index])


@pytest.fixture
def quick() -> Recipe:
    """Three short epochs of a small network."""
    return QUICK
