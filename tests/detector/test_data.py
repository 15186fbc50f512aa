import msgspec
import numpy as np
import pytest
import torch
from conftest import PLAIN

from adc_bench.dataset import FrameDataset
from adc_bench.detector.augment import MIRRORED, AugmentConfig, augment, mirror, relight, zoom
from adc_bench.detector.data import TrainingPictures, epoch_batches, epoch_order, truth_arrays
from adc_bench.detector.paste import Cutting, Example, paste_sign, paste_stripes
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID

UP, LEFT, RIGHT, PARK = (CATEGORIES.index(f"panel_{sign}") for sign in ("up", "left", "right", "park"))


def _example(*entries: tuple[int, tuple[float, float, float, float]]) -> Example:
    """A dark picture 120x100 with a bright box per entry (class, box)."""
    rgb = np.full((100, 120, 3), 40, dtype=np.uint8)
    for k, (_, (x0, y0, x1, y1)) in enumerate(entries):
        rgb[int(y0) : int(y1), int(x0) : int(x1)] = 120 + 40 * k
    boxes = np.array([box for _, box in entries], dtype=np.float32).reshape(-1, 4)
    classes = np.array([category for category, _ in entries], dtype=np.int64)
    return Example(rgb, boxes, classes, np.zeros(len(entries), dtype=np.bool_))


def _lit_box(rgb: np.ndarray, low: int = 80, high: int = 256) -> list[int]:
    rows, columns = np.nonzero((rgb[..., 0] > low) & (rgb[..., 0] < high))
    return [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]


def test_the_mirror_swaps_left_and_right() -> None:
    example = _example((LEFT, (10, 20, 40, 50)), (UP, (60, 30, 90, 45)))
    seen = mirror(example)
    assert seen.classes.tolist() == [RIGHT, UP]
    assert seen.boxes.tolist() == [[80, 20, 110, 50], [30, 30, 60, 45]]
    assert _lit_box(seen.rgb, 100, 140) == [80, 20, 110, 50]
    back = mirror(seen)
    assert np.array_equal(back.rgb, example.rgb) and np.array_equal(back.boxes, example.boxes)
    assert np.array_equal(back.classes, example.classes)


def test_what_has_no_mirror_image_is_not_mirrored() -> None:
    example = _example((PARK, (10, 20, 40, 50)))
    assert mirror(example) is example
    assert all(MIRRORED[MIRRORED[name]] == name for name in MIRRORED)


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_zoom_moves_boxes_with_the_picture(factor: float) -> None:
    seen = zoom(_example((UP, (50, 40, 70, 60))), factor, (7.0, -5.0), 0.4)
    assert seen.boxes[0].tolist() == pytest.approx(_lit_box(seen.rgb), abs=1.01)


def test_what_leaves_the_picture_is_ignored_then_dropped() -> None:
    example = _example((UP, (0, 40, 20, 60)), (LEFT, (0, 40, 100, 60)))
    half_out = zoom(example, 1.0, (-14.0, 0.0), 0.4)
    assert half_out.ignored.tolist() == [True, False]
    assert half_out.boxes.tolist() == [[0, 40, 6, 60], [0, 40, 86, 60]]
    assert zoom(example, 1.0, (-30.0, 0.0), 0.4).classes.tolist() == [LEFT]


def test_light_changes_brightness_and_nothing_else() -> None:
    example = _example((UP, (50, 40, 70, 60)))
    brighter = relight(AugmentConfig(exposure_ev=1.0), example, np.array([1.0, 0, 0, 0, 0]))
    assert brighter.rgb[0, 0].tolist() == [80, 80, 80] and brighter.rgb[50, 60].tolist() == [240, 240, 240]
    assert np.array_equal(brighter.boxes, example.boxes)


def test_pasted_things_never_cover_a_label() -> None:
    rng = np.random.default_rng(0)
    pasted = 0
    for _ in range(60):
        example = _example((UP, (30, 30, 70, 60)))
        cutting = Cutting(np.full((18, 32, 3), 250, dtype=np.uint8), LEFT)
        after = paste_stripes(paste_sign(example, cutting, rng), rng)
        assert (after.rgb[30:60, 30:70] == 120).all()
        if len(after.classes) == 2:
            pasted += 1
            x0, y0, x1, y1 = after.boxes[1].astype(int)
            assert (after.rgb[y0:y1, x0:x1] == 250).all() and after.classes[1] == LEFT
            assert 0 <= x0 < x1 <= 120 and 0 <= y0 < y1 <= 100
    assert pasted > 10


def test_no_change_leaves_a_picture_as_it_is() -> None:
    example = _example((LEFT, (10, 20, 40, 50)))
    seen = augment(PLAIN, example, [], np.random.default_rng(0))
    assert np.array_equal(seen.rgb, example.rgb) and np.array_equal(seen.boxes, example.boxes)


def test_truth_arrays_of_a_real_dataset(training: FrameDataset) -> None:
    for i in range(len(training)):
        labels = training.annotations(i)
        boxes, classes, ignored = truth_arrays(labels)
        assert boxes.shape == (len(labels), 4) and boxes.dtype == np.float32
        assert [CATEGORY_ID[CATEGORIES[k]] for k in classes] == [label.category_id for label in labels]
        assert ignored.tolist() == [label.ignore for label in labels]


def test_examples_depend_on_seed_epoch_and_index_alone(training: FrameDataset) -> None:
    one, same = (TrainingPictures(training, AugmentConfig(), 3, cache_bytes=cache) for cache in (0, 2**30))
    same[(2, 5)]
    assert np.array_equal(one[(1, 7)].rgb, same[(1, 7)].rgb) and np.array_equal(one[(1, 7)].boxes, same[(1, 7)].boxes)
    assert not np.array_equal(one[(1, 7)].rgb, one[(2, 7)].rgb)
    assert not np.array_equal(one[(1, 7)].rgb, TrainingPictures(training, AugmentConfig(), 4)[(1, 7)].rgb)
    assert np.array_equal(one.source.picture(7), training.picture(7))


def test_an_epoch_shows_every_picture_that_shows_something(training: FrameDataset) -> None:
    pictures = TrainingPictures(training, AugmentConfig(), 0)
    shown = {i for i in range(len(training)) if training.annotations(i)}
    first, second = (epoch_order(pictures, epoch, 0.5) for epoch in (0, 1))
    empty = len(training) - len(shown)
    assert len(set(first)) == len(first) == len(second) == len(shown) + round(0.5 * empty)
    assert shown <= set(first) and first != second
    assert sorted(epoch_order(pictures, 0, 1.0)) == list(range(len(training)))


def test_batches_are_the_same_with_worker_processes(training: FrameDataset) -> None:
    pictures = TrainingPictures(training, AugmentConfig(), 0)
    here = list(epoch_batches(pictures, batch=16, epoch=0))
    there = list(epoch_batches(pictures, batch=16, epoch=0, workers=1))
    assert sum(len(rgb) for rgb, _ in here) == len(training)
    for (rgb, truths), (other_rgb, other_truths) in zip(here, there, strict=True):
        assert torch.equal(rgb, other_rgb)
        pairs = zip(truths, other_truths, strict=True)
        assert all(torch.equal(a, b) for one, other in pairs for a, b in zip(one, other, strict=True))


def test_the_augmentation_is_a_record_of_numbers() -> None:
    assert msgspec.convert(msgspec.to_builtins(PLAIN), AugmentConfig) == PLAIN
