"""Changed pictures and what is known of them: boxes and corners stay on what they mark."""

from typing import NamedTuple

import cv2
import msgspec
import numpy as np
import pytest
from conftest import PLAIN
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from adc_bench.dataset import FrameDataset
from adc_bench.detector.training.augment import AugmentConfig, augment
from adc_bench.detector.training.example import DIRECTIONS, Cutting, Example, outline
from adc_bench.detector.training.paste import paste_sign, paste_stripes
from adc_bench.detector.training.pictures import TrainingPictures, load_example
from adc_bench.detector.training.tone import ToneConfig, add_noise, relight, retone, shake
from adc_bench.detector.training.warp import MIRRORED, KeptConfig, WarpConfig, draw_matrix, mirror, mosaic, warp
from adc_bench.world.categories import CATEGORIES

UP, LEFT, RIGHT, PARK = (CATEGORIES.index(f"panel_{sign}") for sign in ("up", "left", "right", "park"))
KEPT = KeptConfig()
Box = tuple[float, float, float, float]
SEEDS = st.integers(0, 10**6)


def _mask(box: Box, height: int = 100, width: int = 120) -> NDArray[np.uint8]:
    mask = np.zeros((height, width), np.uint8)
    x0, y0, x1, y1 = (int(value) for value in box)
    mask[y0:y1, x0:x1] = 1
    return mask


def _corners(box: Box) -> list[tuple[float, float, int]]:
    x0, y0, x1, y1 = box
    return [(x0, y0, 2), (x1, y0, 2), (x1, y1, 2), (x0, y1, 1)]


def _example(*entries: tuple[int, Box]) -> Example:
    """A dark picture 120x100 with a bright box per entry (class, box), its corners seen but for the last, hidden."""
    rgb = np.full((100, 120, 3), 40, dtype=np.uint8)
    for k, (_, (x0, y0, x1, y1)) in enumerate(entries):
        rgb[int(y0) : int(y1), int(x0) : int(x1)] = 120 + 40 * k
    return Example(
        rgb,
        np.array([outline(_mask(box)) for _, box in entries], np.float32).reshape(-1, DIRECTIONS.shape[1], 2),
        np.array([category for category, _ in entries], np.int64),
        np.zeros(len(entries), np.bool_),
        np.array([_corners(box) for _, box in entries], np.float32).reshape(-1, 4, 3),
    )


def _lit_box(rgb: NDArray[np.uint8], low: int = 80, high: int = 256) -> list[int]:
    rows, columns = np.nonzero((rgb[..., 0] > low) & (rgb[..., 0] < high))
    return [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]


class Nothing(NamedTuple):
    """A supply of one picture and no signs."""

    other: Example

    def example(self, rng: np.random.Generator, /) -> Example:
        return self.other

    def sign(self, rng: np.random.Generator, /) -> Cutting | None:
        return None


@given(seed=SEEDS)
@settings(max_examples=30, deadline=None, derandomize=True)
def test_an_outline_reaches_as_far_as_the_turned_mask(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mask = np.zeros((60, 80), np.uint8)
    cv2.fillPoly(mask, [rng.integers(0, (80, 60), (5, 2)).astype(np.int32)], (1,))
    angle = rng.uniform(-0.1, 0.1)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    rows, columns = np.nonzero(mask)
    pixels = np.concatenate([np.stack([columns + du, rows + dv], axis=1) for du in (0, 1) for dv in (0, 1)]) @ turn.T
    turned = outline(mask) @ turn.T
    assert turned.min(axis=0) == pytest.approx(pixels.min(axis=0), abs=0.4)
    assert turned.max(axis=0) == pytest.approx(pixels.max(axis=0), abs=0.4)


def test_boxes_are_those_of_the_labels(training: FrameDataset) -> None:
    for i in range(len(training)):
        labels = training.annotations(i)
        example = load_example(training, i)
        assert example.boxes.tolist() == [list(label.box_px) for label in labels]
        assert example.boxes.dtype == np.float32 and example.boxes.shape == (len(labels), 4)


def test_the_mirror_swaps_left_and_right() -> None:
    example = _example((LEFT, (10, 20, 40, 50)), (UP, (60, 30, 90, 45)))
    seen = mirror(example)
    assert seen.classes.tolist() == [RIGHT, UP]
    assert seen.boxes.tolist() == [[80, 20, 110, 50], [30, 30, 60, 45]]
    assert _lit_box(seen.rgb, 100, 140) == [80, 20, 110, 50]
    assert seen.keypoints[0].tolist() == [[80, 20, 2], [110, 20, 2], [110, 50, 1], [80, 50, 2]]
    back = mirror(seen)
    assert all(np.array_equal(one, other) for one, other in zip(back, example, strict=True))


def test_what_has_no_mirror_image_is_not_mirrored() -> None:
    example = _example((PARK, (10, 20, 40, 50)))
    assert mirror(example) is example
    assert all(MIRRORED[MIRRORED[name]] == name for name in MIRRORED)


@given(seed=SEEDS)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_boxes_and_corners_move_with_the_picture(seed: int) -> None:
    matrix = draw_matrix(WarpConfig(zoom=2.0, turn_rad=0.1, shear=0.1), (120, 100), np.random.default_rng(seed))
    example = _example((UP, (45, 40, 75, 60)))
    seen = warp(KEPT, example, matrix, (120, 100))
    assert seen.boxes[0].tolist() == pytest.approx(_lit_box(seen.rgb), abs=1.6)
    exact = cv2.transform(example.keypoints[..., :2].astype(np.float64), matrix)[0]
    for (u, v, state), (true_u, true_v), before in zip(seen.keypoints[0], exact, (2, 2, 2, 1), strict=True):
        inside = 0 <= true_u < 120 and 0 <= true_v < 100
        assert (u, v, state) == (pytest.approx((true_u, true_v, before), abs=1e-3) if inside else (0, 0, 0))
    # The picture is bright where the way back leads into the box.
    v, u = np.mgrid[0:100, 0:120] + 0.5
    back = cv2.invertAffineTransform(matrix)
    x, y = (row[0] * u + row[1] * v + row[2] for row in back)
    expected = (abs(x - 60) < 15) & (abs(y - 50) < 10)
    lit = seen.rgb[..., 0] > 80
    assert (lit & expected).sum() > 0.97 * (lit | expected).sum()


def test_what_leaves_the_picture_is_ignored_then_dropped() -> None:
    example = _example((UP, (0, 40, 20, 60)), (LEFT, (0, 40, 100, 60)))
    half_out = warp(KEPT, example, np.array([[1.0, 0, -14], [0, 1, 0]]), (120, 100))
    assert half_out.ignored.tolist() == [True, False]
    assert half_out.boxes.tolist() == [[0, 40, 6, 60], [0, 40, 86, 60]]
    assert half_out.keypoints[0].tolist() == [[0, 0, 0], [6, 40, 2], [6, 60, 2], [0, 0, 0]]
    assert warp(KEPT, example, np.array([[1.0, 0, -30], [0, 1, 0]]), (120, 100)).classes.tolist() == [LEFT]


@given(seed=SEEDS)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_a_mosaic_shows_parts_of_four_pictures(seed: int) -> None:
    rng = np.random.default_rng(seed)
    classes = (UP, LEFT, RIGHT, PARK)
    tiles = [_example((k, (40, 30, 80, 70))) for k in classes]
    for tile, level in zip(tiles, (100, 140, 180, 220), strict=True):
        tile.rgb[30:70, 40:80] = level
    seen = mosaic(KEPT, tiles, rng)
    assert seen.rgb.shape == (100, 120, 3)
    for box, category, ignored, keypoints in zip(seen.boxes, seen.classes, seen.ignored, seen.keypoints, strict=True):
        level = (100, 140, 180, 220)[classes.index(int(category))]
        lit = np.abs(seen.rgb[..., 0].astype(int) - level) < 15
        x0, y0, x1, y1 = np.rint(box).astype(int)
        inside = lit[y0 + 2 : y1 - 2, x0 + 2 : x1 - 2]
        assert inside.mean() > 0.9 if inside.size else ignored
        corners = keypoints[keypoints[:, 2] > 0, :2]
        at_corner = np.abs(corners[:, None] - box.reshape(2, 2)).min(axis=1)
        assert (at_corner < 0.01).all()


def test_a_mosaic_carries_regions_to_ignore() -> None:
    tile = _example((UP, (20, 20, 100, 80)))._replace(ignored=np.array([True]))
    seen = mosaic(KEPT, [tile] * 4, np.random.default_rng(0))
    assert len(seen.classes) == 4 and seen.ignored.all()


def test_light_changes_brightness_and_nothing_else() -> None:
    rgb = _example((UP, (50, 40, 70, 60))).rgb
    brighter = relight(ToneConfig(exposure_ev=1.0), rgb, np.array([1.0, 0, 0, 0, 0, 0]))
    assert brighter[0, 0].tolist() == [80, 80, 80] and brighter[50, 60].tolist() == [240, 240, 240]
    contrast = relight(ToneConfig(contrast=2.0), rgb, np.array([0, 0, 1.0, 0, 0, 0])).astype(int)
    assert contrast[50, 60, 0] - contrast[0, 0, 0] > 1.5 * 80
    assert np.array_equal(relight(ToneConfig(), rgb, np.zeros(6)), rgb)


def test_shaking_smears_along_its_line_alone() -> None:
    rgb = np.zeros((41, 41, 3), np.uint8)
    rgb[20, 20] = 255
    seen = shake(rgb, 9.0, 0.0)[..., 0]
    assert np.flatnonzero(seen.any(axis=1)).tolist() == [20]
    assert np.flatnonzero(seen[20]).tolist() == list(range(16, 25))
    assert seen[20].sum() == pytest.approx(255, abs=6)


def test_noise_has_the_deviation_asked_for() -> None:
    rgb = np.full((120, 160, 3), 120, np.uint8)
    seen = add_noise(rgb, 6.0, np.random.default_rng(0)).astype(float)
    assert seen.std() == pytest.approx(6.0, rel=0.05) and seen.mean() == pytest.approx(120, abs=0.2)


def test_tones_leave_a_picture_a_picture() -> None:
    rgb, rng = _example((UP, (50, 40, 70, 60))).rgb, np.random.default_rng(0)
    always = ToneConfig(light=1.0, motion=1.0, defocus=1.0, noise=1.0)
    for _ in range(20):
        seen = retone(always, rgb, rng)
        assert seen.dtype == np.uint8 and seen.shape == rgb.shape
        assert seen[45:55, 55:65].mean() > seen[:30, :30].mean()


def test_pasted_things_never_cover_a_label() -> None:
    rng = np.random.default_rng(0)
    pasted = 0
    for _ in range(60):
        example = _example((UP, (30, 30, 70, 60)))
        bounds = outline(np.ones((18, 32), np.uint8))
        corners = np.array([(0, 0, 2), (32, 0, 2), (32, 18, 1), (0, 0, 0)], np.float32)
        cutting = Cutting(np.full((18, 32, 3), 250, dtype=np.uint8), LEFT, bounds, corners)
        after = paste_stripes(paste_sign(example, cutting, rng), rng)
        assert (after.rgb[30:60, 30:70] == 120).all()
        if len(after.classes) == 2:
            pasted += 1
            x0, y0, x1, y1 = after.boxes[1].round().astype(int)
            assert (after.rgb[y0:y1, x0:x1] == 250).all() and after.classes[1] == LEFT
            assert 0 <= x0 < x1 <= 120 and 0 <= y0 < y1 <= 100
            assert after.keypoints[1].round().tolist() == [[x0, y0, 2], [x1, y0, 2], [x1, y1, 1], [0, 0, 0]]
    assert pasted > 10


def test_no_change_leaves_a_picture_as_it_is() -> None:
    example = _example((LEFT, (10, 20, 40, 50)))
    seen = augment(PLAIN, example, Nothing(example), np.random.default_rng(0), with_mosaic=True)
    assert all(np.array_equal(one, other) for one, other in zip(seen, example, strict=True))


def test_mosaics_come_only_where_they_are_wanted() -> None:
    example, other = _example(), _example()._replace(rgb=np.full((100, 120, 3), 200, np.uint8))
    config = msgspec.structs.replace(PLAIN, mosaic=1.0)
    with_it, without = (
        augment(config, example, Nothing(other), np.random.default_rng(0), with_mosaic=wanted)
        for wanted in (True, False)
    )
    assert (with_it.rgb == 200).mean() > 0.5 and (without.rgb == 40).all()


def test_too_small_objects_are_ignored() -> None:
    example = _example((LEFT, (10, 20, 13, 50)), (UP, (50, 50, 54, 54)))
    seen = augment(PLAIN, example, Nothing(example), np.random.default_rng(0), with_mosaic=False)
    assert seen.ignored.tolist() == [True, False]


def test_changed_pictures_of_a_real_dataset_keep_sound_truth(training: FrameDataset) -> None:
    pictures = TrainingPictures(training, AugmentConfig(), 0)
    for index in range(len(pictures)):
        seen = pictures.changed(0, index, plain=False)
        count = len(seen.classes)
        assert seen.rgb.shape == (120, 160, 3) and seen.rgb.dtype == np.uint8
        assert seen.boxes.shape == (count, 4) and seen.keypoints.shape == (count, 4, 3) and len(seen.ignored) == count
        assert (seen.boxes >= 0).all() and (seen.boxes <= (160, 120, 160, 120)).all()
        assert ((seen.boxes[:, 2:] - seen.boxes[:, :2]) > 0).all()
        known = seen.keypoints[seen.keypoints[..., 2] > 0]
        assert (known[:, :2] >= 0).all() and (known[:, :2] <= (160, 120)).all()
        assert not seen.keypoints[seen.keypoints[..., 2] == 0].any()


def test_the_augmentation_is_a_record_of_numbers() -> None:
    assert msgspec.convert(msgspec.to_builtins(PLAIN), AugmentConfig) == PLAIN
