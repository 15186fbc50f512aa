"""Datasets as training reads them: arrays, changed pictures, batches; and datasets that cannot be learned from."""

import msgspec
import numpy as np
import pytest
import torch

from adc_bench.dataset import FrameDataset
from adc_bench.detector.data import truth_arrays
from adc_bench.detector.training.augment import AugmentConfig
from adc_bench.detector.training.batches import Batch, BatchConfig, epoch_order, run_batches, steps_per_epoch
from adc_bench.detector.training.data_checks import check_classes
from adc_bench.detector.training.pictures import TrainingPictures
from adc_bench.errors import InputError
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID
from adc_bench.world.corners_seen import keypoints_as_seen


def _equal(one: Batch, other: Batch) -> bool:
    pairs = [(a, b) for t, u in zip(one.truths, other.truths, strict=True) for a, b in zip(t, u, strict=True)]
    return torch.equal(one.pictures, other.pictures) and all(torch.equal(a, b) for a, b in pairs)


@pytest.fixture(scope="module")
def pictures(training: FrameDataset) -> TrainingPictures:
    return TrainingPictures(training, AugmentConfig(), 0)


def test_truth_arrays_of_a_real_dataset(training: FrameDataset) -> None:
    for i in range(len(training)):
        labels = training.annotations(i)
        boxes, classes, ignored = truth_arrays(labels)
        assert boxes.shape == (len(labels), 4) and boxes.dtype == np.float32
        assert [CATEGORY_ID[CATEGORIES[k]] for k in classes] == [label.category_id for label in labels]
        assert ignored.tolist() == [label.ignore for label in labels]


def test_a_crosswalks_corners_go_round_from_the_far_left(training: FrameDataset) -> None:
    """Seen from before it, the corners run clockwise in the picture, the far ones above the near ones."""
    whole = 0
    for i in range(len(training)):
        labels = [label for label in training.annotations(i) if label.category_id == CATEGORY_ID["crosswalk"]]
        for corners in keypoints_as_seen(labels, towards_plus_x=training.pose_world_camera(i)[0, 2] > 0):
            if (corners[:, 2] > 0).all():
                whole += 1
                far_left, far_right, near_right, near_left = corners[:, :2]
                assert far_left[0] < far_right[0] and near_left[0] < near_right[0]
                assert far_left[1] < near_left[1] and far_right[1] < near_right[1]
    assert whole > 2


def test_examples_depend_on_seed_epoch_and_index_alone(training: FrameDataset) -> None:
    one, same = (TrainingPictures(training, AugmentConfig(), 3, cache_bytes=cache) for cache in (0, 2**30))
    same.changed(2, 5, plain=False)
    for index in range(7, 12):
        here, there = (pictures.changed(1, index, plain=False) for pictures in (one, same))
        assert all(np.array_equal(a, b) for a, b in zip(here, there, strict=True))
    assert not np.array_equal(here.rgb, one.changed(2, 11, plain=False).rgb)
    other_seed = TrainingPictures(training, AugmentConfig(), 4).changed(1, 11, plain=False)
    assert not np.array_equal(here.rgb, other_seed.rgb)
    assert np.array_equal(same._held(7).rgb, training.picture(7)), "what is held must stay as it was read"


def test_what_is_held_stays_within_its_bounds(training: FrameDataset) -> None:
    pictures = TrainingPictures(training, AugmentConfig(), 0, cache_bytes=5 * 160 * 120 * 3)
    for i in range(len(pictures)):
        pictures.changed(0, i, plain=False)
    assert 1 <= len(pictures._cache) <= 5


def test_an_epoch_shows_every_picture_that_shows_something(training: FrameDataset, pictures: TrainingPictures) -> None:
    shown = {i for i in range(len(training)) if training.annotations(i)}
    config = BatchConfig(batch=8, empty_share=0.5)
    first, second = (epoch_order(pictures, config, epoch) for epoch in (0, 1))
    empty = len(training) - len(shown)
    assert len(set(first)) == len(first) == len(second) == len(shown) + round(0.5 * empty)
    assert shown <= set(first) and first != second
    assert sorted(epoch_order(pictures, BatchConfig(batch=8), 0)) == list(range(len(training)))


def test_batches_are_the_same_with_worker_processes(training: FrameDataset, pictures: TrainingPictures) -> None:
    here, there = (list(run_batches(pictures, BatchConfig(batch=16, workers=workers), epochs=2)) for workers in (0, 1))
    assert sum(len(batch.pictures) for batch in here) == 2 * len(training)
    assert [batch.indices for batch in here[:3]] != [batch.indices for batch in here[3:]]
    assert all(_equal(one, other) for one, other in zip(here, there, strict=True))


@pytest.mark.parametrize("first", [1, 2, 3, 5])
def test_batches_go_on_anywhere(pictures: TrainingPictures, first: int) -> None:
    config = BatchConfig(batch=16)
    whole = list(run_batches(pictures, config, epochs=2))
    assert len(whole) == 2 * steps_per_epoch(pictures, config)
    rest = list(run_batches(pictures, config, epochs=2, first=first))
    assert all(_equal(one, other) for one, other in zip(whole[first:], rest, strict=True))


def test_processes_share_a_batch(pictures: TrainingPictures) -> None:
    whole = list(run_batches(pictures, BatchConfig(batch=16), epochs=1))
    shares = [list(run_batches(pictures, BatchConfig(batch=16, rank=k, processes=3), epochs=1)) for k in range(3)]
    for batch, *parts in zip(whole, *shares, strict=True):
        assert sorted(i for part in parts for i in part.indices) == sorted(batch.indices)
        alone = {index: batch.pictures[k] for k, index in enumerate(batch.indices)}
        assert all(torch.equal(x, alone[i]) for part in parts for i, x in zip(part.indices, part.pictures, strict=True))


def test_no_process_is_left_without_a_picture(pictures: TrainingPictures) -> None:
    config = BatchConfig(batch=len(pictures) - 1, rank=3, processes=4)
    assert [len(batch.indices) for batch in run_batches(pictures, config, epochs=1)][-1] == 1


class Broken:
    """A dataset of which one picture cannot be read."""

    def __init__(self, source: FrameDataset) -> None:
        self.source, self.image_ids = source, source.image_ids
        self.annotations, self.pose_world_camera = source.annotations, source.pose_world_camera
        self.conditions, self.pose_world_robot, self.mount = source.conditions, source.pose_world_robot, source.mount

    def __len__(self) -> int:
        return len(self.source)

    def picture(self, index: int) -> np.ndarray:
        if index == 7:
            raise InputError(where="frame 7", found="a hole", wanted="a picture", todo="mend it")
        return self.source.picture(index)


@pytest.mark.parametrize("workers", [0, 1])
def test_a_damaged_picture_is_told_from_any_process(training: FrameDataset, workers: int) -> None:
    pictures = TrainingPictures(Broken(training), AugmentConfig(), 0)
    with pytest.raises(InputError, match=r"frame 7\n +found: +a hole"):
        list(run_batches(pictures, BatchConfig(batch=8, workers=workers), epochs=1))


def test_a_dataset_of_other_classes_is_refused(training: FrameDataset, monkeypatch: pytest.MonkeyPatch) -> None:
    check_classes(training)
    manifest, summary = training.manifest, training.manifest.summary
    assert summary is not None
    boxes = {("zebra" if name == "crosswalk" else name): count for name, count in summary.boxes.items()}
    other = msgspec.structs.replace(manifest, summary=msgspec.structs.replace(summary, boxes=boxes))
    monkeypatch.setattr(training, "manifest", other)
    with pytest.raises(InputError, match=r"dataset.toml\n +found: +labels of other classes: crosswalk, zebra are not"):
        check_classes(training)
