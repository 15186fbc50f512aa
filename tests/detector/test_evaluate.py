import contextlib
import io

import numpy as np
import pytest
from made_answers import Labels, answer, label
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from adc_bench.detector.evaluation import Evaluation
from adc_bench.detector.evaluation.circumstances import box_side_px
from adc_bench.detector.evaluation.matching import match
from adc_bench.detector.evaluation.score import CocoScorer
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Detections, Label

A, B = (10.0, 10.0, 50.0, 50.0), (100.0, 100.0, 140.0, 140.0)
A_WIDE = (10.0, 10.0, 50.0, 60.0)  # overlaps A by 0.8: right at the overlaps 0.50 to 0.75, and at 0.80 itself


def test_two_found_of_two_is_one() -> None:
    score = Evaluation(
        Labels([[label("crosswalk", A)], [label("crosswalk", B)]]),
        [answer(("crosswalk", 0.9, A)), answer(("crosswalk", 0.8, B))],
    ).score()
    assert score.map == score.map50 == 1.0
    assert score.categories["crosswalk"].objects == 2 and list(score.categories) == ["crosswalk"]


def test_a_hand_made_case() -> None:
    """Ranked: right, wrong, right of three objects. Precision 1 up to recall 1/3, then 2/3 up to recall 2/3: of the 101
    recalls 34 lie up to 1/3 and 33 up to 2/3, so AP50 = (34 + 33 * 2/3) / 101.
    """
    truth = Labels([[label("panel_up", A), label("panel_up", B)], [label("panel_up", A)]])
    found = [answer(("panel_up", 0.9, A), ("panel_up", 0.8, (200, 200, 220, 220))), answer(("panel_up", 0.7, A))]
    score = Evaluation(truth, found).score()
    assert score.map50 == pytest.approx((34 + 33 * 2 / 3) / 101, abs=1e-6)
    assert score.map == score.map50  # what is found is found exactly


def test_a_loose_box_counts_only_at_low_overlap() -> None:
    score = Evaluation(Labels([[label("crosswalk", A)]]), [answer(("crosswalk", 0.9, A_WIDE))]).score()
    assert score.map50 == 1.0 and score.map == pytest.approx(0.7, abs=1e-6)


def test_ignored_regions_count_neither_way() -> None:
    truth = Labels([[label("crosswalk", A), label("crosswalk", B, ignore=True)]])
    found = [answer(("crosswalk", 0.95, (105, 105, 135, 135)), ("crosswalk", 0.9, A))]
    assert Evaluation(truth, found).score().categories["crosswalk"].ap == 1.0
    assert Evaluation(truth, [answer(("crosswalk", 0.9, A))]).score().categories["crosswalk"].objects == 1


def test_absent_categories_are_no_part_of_the_mean() -> None:
    truth = Labels([[label("crosswalk", A), label("panel_stop", B)]])
    score = Evaluation(truth, [answer(("crosswalk", 0.9, A), ("cone", 0.9, B))]).score()
    assert {name: entry.ap for name, entry in score.categories.items()} == {"crosswalk": 1.0, "panel_stop": 0.0}
    assert score.map == 0.5


def test_nothing_found_and_nothing_there() -> None:
    assert Evaluation(Labels([[label("crosswalk", A)]]), [answer()]).score().map == 0.0
    assert Evaluation(Labels([[]]), [answer(("crosswalk", 0.9, A))]).score().categories == {}


CROWD = ["crosswalk", "panel_up", "cone"]


def _at_random(rng: np.random.Generator, pictures: int) -> tuple[list[list[Label]], list[Detections]]:
    """Pictures with crowded objects, regions to ignore among them, and answers near them and elsewhere."""
    labels, found = [], []
    for _ in range(pictures):
        truth = [
            label(str(rng.choice(CROWD)), _box(rng), ignore=bool(rng.random() < 0.2)) for _ in range(rng.integers(6))
        ]
        entries = [
            (_name(one, rng), round(float(rng.random()), 3), _moved(one.box_px, rng))
            for one in truth
            for _ in range(rng.integers(3))
        ]
        entries += [(str(rng.choice(CROWD)), round(float(rng.random()), 3), _box(rng)) for _ in range(rng.integers(3))]
        labels.append(truth)
        found.append(answer(*sorted(entries, key=lambda entry: -entry[1])))
    return labels, found


def _name(one: Label, rng: np.random.Generator) -> str:
    return CATEGORIES[one.category_id - 1] if rng.random() < 0.8 else str(rng.choice(CROWD))


def _box(rng: np.random.Generator) -> tuple[float, float, float, float]:
    x, y = rng.uniform(0, 60, 2)
    w, h = rng.uniform(5, 80, 2)
    return float(x), float(y), float(x + w), float(y + h)


def _moved(box: tuple[float, float, float, float], rng: np.random.Generator) -> tuple[float, float, float, float]:
    x0, y0, x1, y1 = (float(value) for value in np.array(box) + rng.normal(0, 3, 4))
    return x0, y0, max(x1, x0 + 1), max(y1, y0 + 1)


def _by_pycocotools(labels: list[list[Label]], found: list[Detections], ranges: list[list[float]]) -> COCOeval:
    """pycocotools at overlap 0.50, over ranges of true areas in px."""
    truth = [
        _coco_entry(i, one.category_id, one.box_px, iscrowd=int(one.ignore))
        for i, of_picture in enumerate(labels)
        for one in of_picture
    ]
    answers = [
        _coco_entry(i, int(category), box.tolist(), iscrowd=0, score=float(score))
        for i, one in enumerate(found)
        for category, box, score in zip(one.category_ids, one.boxes_px, one.scores, strict=True)
    ]
    with contextlib.redirect_stdout(io.StringIO()):
        run = COCOeval(*(_coco(entries, len(labels)) for entries in (truth, answers)), "bbox")
        run.params.areaRng, run.params.areaRngLbl, run.params.maxDets = ranges, [str(each) for each in ranges], [100]
        run.params.iouThrs = np.array([0.5])
        run.evaluate()
        run.accumulate()
    return run


def _coco_entry(image_id: int, category_id: int, box: list[float], **more: float) -> dict[str, object]:
    x0, y0, x1, y1 = box
    area = (x1 - x0) * (y1 - y0)
    return {"image_id": image_id, "category_id": category_id, "bbox": [x0, y0, x1 - x0, y1 - y0], "area": area, **more}


def _coco(entries: list[dict[str, object]], pictures: int) -> COCO:
    coco = COCO()
    coco.dataset = {
        "images": [{"id": i} for i in range(pictures)],
        "annotations": [{"id": k, **entry} for k, entry in enumerate(entries, 1)],
        "categories": [{"id": k} for k in range(1, len(CATEGORIES) + 1)],
    }
    coco.createIndex()
    return coco


def test_who_belongs_to_whom_is_as_pycocotools_has_it() -> None:
    labels, found = _at_random(np.random.default_rng(0), 200)
    matches = match(labels, found)
    theirs = np.full(len(matches.scores), -1)
    counted = np.ones(len(matches.scores), bool)
    for entry in _by_pycocotools(labels, found, [[0, 1e9]]).evalImgs:
        if entry is not None:
            detections = np.array(entry["dtIds"], int) - 1
            ignored = entry["dtIgnore"][0].astype(bool)
            matched = entry["dtMatches"][0].astype(int) - 1
            theirs[detections] = np.where(ignored, -1, matched)
            counted[detections] = ~ignored
    assert (matches.label >= 0).sum() > 150 and (~matches.counted).sum() > 50
    np.testing.assert_array_equal(matches.label, theirs)
    np.testing.assert_array_equal(matches.counted, counted)
    taken = matches.label[matches.label >= 0]
    np.testing.assert_array_equal(np.flatnonzero(matches.found_by >= 0), np.sort(taken))


def test_less_sure_detections_change_nothing_for_the_others() -> None:
    labels, found = _at_random(np.random.default_rng(1), 60)
    sure = [
        Detections(**{name: getattr(one, name)[one.scores >= 0.5] for name in Detections.__dataclass_fields__})
        for one in found
    ]
    everything, some = match(labels, found), match(labels, sure)
    np.testing.assert_array_equal(
        everything.found_score() * (everything.found_score() >= 0.5), some.found_score().clip(0)
    )
    assert everything.wrong(0.5).sum() == some.wrong(0.5).sum()


def test_bands_of_size_are_coco_s_ranges_of_area() -> None:
    labels, found = _at_random(np.random.default_rng(2), 80)
    scorer = CocoScorer(range(80), labels, found)
    sides = [box_side_px(one.box_px) for of_picture in labels for one in of_picture]
    found_sides = [box_side_px(box) for one in found for box in one.boxes_px]
    scores = scorer.score_bands(((0.0, 30.0), (30.0, np.inf)), sides, found_sides)
    run = _by_pycocotools(labels, found, ranges=[[0, 30.0**2], [30.0**2, 1e9]])
    for k, score in enumerate(scores):
        for number, name in enumerate(CATEGORIES):
            expected = run.eval["precision"][0, :, number, k, 0].mean()
            assert (score.categories[name].ap50 if name in score.categories else -1) == pytest.approx(
                expected, abs=1e-6
            )
    counts = [sum(entry.objects for entry in score.categories.values()) for score in scores]
    assert min(counts) > 10
    assert sum(counts) == sum(entry.objects for entry in scorer.score().categories.values())


def test_objects_outside_a_band_are_ignored_with_what_was_found_of_them() -> None:
    near, far = label("crosswalk", A, distance_m=1.0), label("crosswalk", B, distance_m=5.0)
    scorer = CocoScorer([0], [[near, far]], [answer(("crosswalk", 0.9, B), ("crosswalk", 0.8, A))])
    first, second = scorer.score_bands(((0.0, 2.0), (2.0, np.inf)), [1.0, 5.0])
    assert first.map == second.map == 1.0
    assert first.categories["crosswalk"].objects == second.categories["crosswalk"].objects == 1


def test_a_detection_of_nothing_counts_against_its_own_band_if_that_is_known_and_else_against_all() -> None:
    scorer = CocoScorer(
        [0],
        [[label("cone", A), label("cone", B)]],
        [answer(("cone", 0.9, (0, 0, 5, 5)), ("cone", 0.8, A), ("cone", 0.7, B))],
    )
    bands = ((0.0, 2.0), (2.0, np.inf))
    own, other = scorer.score_bands(bands, [1.0, 5.0], [1.0, 1.0, 5.0])
    assert own.map50 == pytest.approx(0.5) and other.map50 == 1.0
    assert [score.map50 for score in scorer.score_bands(bands, [1.0, 5.0])] == pytest.approx([0.5, 0.5])
