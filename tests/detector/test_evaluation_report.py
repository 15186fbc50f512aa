import re
from html.parser import HTMLParser

import msgspec
import numpy as np
import pytest
from made_answers import Labels, answer, label, perfect_answers

from adc_bench.dataset import FrameDataset
from adc_bench.detector.evaluation import DetectionReport, Evaluation
from adc_bench.detector.evaluation.calibration import calibration
from adc_bench.detector.evaluation.matching import Matches, match
from adc_bench.detector.evaluation.operating import choose_threshold, operating_point, pictures_without
from adc_bench.detector.evaluation.page import page_of
from adc_bench.detector.evaluation.table import markdown_lines, text_lines
from adc_bench.detector.evaluation.tables import tables
from adc_bench.world.frame import Detections

A, B = (10.0, 10.0, 50.0, 50.0), (100.0, 100.0, 140.0, 140.0)


@pytest.fixture(scope="module")
def perfect(validation: FrameDataset) -> Evaluation:
    return Evaluation(validation, perfect_answers(validation))


@pytest.fixture(scope="module")
def report(perfect: Evaluation) -> DetectionReport:
    return perfect.report()


def test_the_truth_as_the_answer_is_perfect_everywhere(report: DetectionReport) -> None:
    assert report.overall.map == report.overall.map50 == 1.0
    for parts in report.circumstances.values():
        for part in parts.values():
            assert part.score.map == (1.0 if part.recall.objects else 0.0)
            assert part.recall.recall in (1.0, None)
    point = report.operating
    assert point.precision == point.recall == 1.0
    assert point.false_crosswalks == 0 and point.invented_on_empty == {}
    assert point.crosswalk_recall["all"].objects > 5 and point.crosswalk_recall["all"].recall == 1.0


def test_the_circumstances_part_pictures_and_objects(report: DetectionReport, validation: FrameDataset) -> None:
    objects = sum(entry.objects for entry in report.overall.categories.values())
    for kind in ("light", "tunnel", "blur"):
        parts = report.circumstances[kind].values()
        assert sum(part.score.pictures for part in parts) == len(validation)
        assert sum(part.recall.objects for part in parts) == objects
    for kind in ("size", "distance", "visible"):
        parts = report.circumstances[kind].values()
        assert sum(part.recall.objects for part in parts) == objects
        for part in parts:
            assert sum(entry.objects for entry in part.score.categories.values()) == part.recall.objects


def test_the_answers_of_other_pictures_are_worth_little(validation: FrameDataset) -> None:
    answers = perfect_answers(validation)
    shuffled = Evaluation(validation, [answers[(i + 7) % len(answers)] for i in range(len(answers))]).report()
    assert shuffled.overall.map < 0.1
    assert shuffled.operating.precision < 0.2 and shuffled.operating.false_crosswalks > 2


def test_no_answers_are_worth_nothing(validation: FrameDataset) -> None:
    empty = Evaluation(validation, [answer()] * len(validation)).report()
    assert empty.overall.map == 0.0 and empty.operating.recall == 0.0 and empty.operating.precision is None
    assert empty.calibration.expected_error is None and empty.floor["2-4 m"].found.median is None
    assert msgspec.json.decode(msgspec.json.encode(empty), type=DetectionReport) == empty


def test_equal_answers_give_equal_bytes(perfect: Evaluation, validation: FrameDataset) -> None:
    again = Evaluation(validation, perfect_answers(validation))
    assert msgspec.json.encode(again.report()) == msgspec.json.encode(perfect.report())


def _scored(truth: list[list[str]], answers: list[list[tuple[str, float]]]) -> Matches:
    """Objects and answers by name; answer k of a picture lies on object k, or elsewhere where there is none."""
    places = [(60.0 * k, 0.0, 60.0 * k + 50, 40.0) for k in range(8)]
    labels = [[label(name, places[k]) for k, name in enumerate(names)] for names in truth]
    found = [answer(*((name, score, places[k]) for k, (name, score) in enumerate(one))) for one in answers]
    return match(labels, found)


def test_the_threshold_has_the_best_f1() -> None:
    truth = [["cone"]] * 10
    answers = [[("cone", 0.62), ("cone", 0.41)]] * 10  # each second one is of nothing
    assert choose_threshold(_scored(truth, answers)) == 0.45


def test_the_threshold_lies_above_every_crosswalk_where_there_is_none() -> None:
    truth = [["cone"]] * 10 + [[]]
    answers = [[("cone", 0.62)]] * 10 + [[("crosswalk", 0.71)]]
    assert choose_threshold(_scored(truth, answers)) == 0.75
    assert choose_threshold(_scored(truth, [*answers[:-1], [("panel_up", 0.71)]])) == 0.05


def test_what_is_invented_is_counted_by_category() -> None:
    source = Labels([[], [label("cone", A)], [label("crosswalk", A, ignore=True)], [label("crosswalk", A)]])
    found = [
        answer(("crosswalk", 0.9, A), ("cone", 0.5, B), ("cone", 0.2, A)),
        answer(("crosswalk", 0.6, B), ("cone", 0.5, A)),
        answer(("crosswalk", 0.9, B)),
        answer(("crosswalk", 0.9, B)),
    ]
    matches = match(source.labels, found)
    point = operating_point(source, matches, 0.4)
    assert point.empty_pictures == 1 and point.invented_on_empty == {"crosswalk": 1, "cone": 1}
    assert pictures_without(matches, 1).tolist() == [True, True, False, False]
    assert point.pictures_without_crosswalk == 2 and point.false_crosswalks == 2
    assert point.precision == pytest.approx(1 / 6, abs=1e-6) and point.recall == 0.5


def test_crosswalks_are_asked_for_within_their_range() -> None:
    source = Labels(
        [[label("crosswalk", A, distance_m=distance_m)] for distance_m in (0.4, 1.0, 3.9, 4.1)]
        + [[label("crosswalk", A, distance_m=2.0, ignore=True)]]
    )
    found = [answer(("crosswalk", score, A)) for score in (0.9, 0.9, 0.3, 0.9, 0.9)]
    recall = operating_point(source, match(source.labels, found), 0.4).crosswalk_recall
    assert (recall["all"].objects, recall["all"].found, recall["all"].recall) == (2, 1, 0.5)
    assert recall["tunnel"].objects == 0 and recall["tunnel"].recall is None
    assert recall["darkest light"].objects == 1 and recall["darkest light"].found == 0


@pytest.mark.parametrize(("power", "gap"), [(1.0, 0.0), (2.0, 1 / 6)])
def test_calibration_of_scores_made_to_be_right_so_often(power: float, gap: float) -> None:
    """Detections that are right with the probability score^power: over scores spread evenly in 0.1..1 the mean gap is
    the integral of s - s^power.
    """
    rng = np.random.default_rng(3)
    scores = rng.uniform(0.1, 1.0, 8000)
    right = rng.random(8000) < scores**power
    labels = [[label("cone", A)] if hit else [] for hit in right]
    result = calibration(match(labels, [answer(("cone", float(score), A)) for score in scores]))
    expected = (1 - 0.01) / 2 / 0.9 - (1 - 0.1 ** (power + 1)) / (power + 1) / 0.9
    assert result.expected_error == pytest.approx(expected, abs=0.015) and expected == pytest.approx(gap, abs=0.02)
    for each in result.bins:
        assert each.mean_score == pytest.approx((each.low + each.high) / 2, abs=0.01)
        assert each.right == pytest.approx(each.mean_score**power, abs=0.06)


def test_the_last_bin_holds_a_score_of_one_and_none_holds_what_nobody_believes() -> None:
    bins = calibration(_scored([["cone"]] * 2, [[("cone", 1.0)], [("cone", 0.05)]])).bins
    assert [each.count for each in bins] == [0] * 8 + [1]


class _Page(HTMLParser):
    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.sources: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.sources += [value or "" for name, value in attrs if name in ("src", "srcset", "href")]


def test_the_page_needs_nothing_beside_itself_and_shows_mistakes(validation: FrameDataset) -> None:
    answers = perfect_answers(validation)
    answers[3] = answer(("crosswalk", 0.99, (5.0, 5.0, 60.0, 40.0)))
    shifted = [Detections(**{**_fields(one), "keypoints_px": one.keypoints_px + 2}) for one in answers]
    evaluation = Evaluation(validation, shifted)
    page = page_of(evaluation, evaluation.report(), "weights <of> a test")
    again = page_of(evaluation, evaluation.report(), "weights <of> a test")
    assert page == again
    parsed = _Page(page.decode())
    assert all(source.startswith("data:") for source in parsed.sources)
    assert parsed.tags.count("picture") == 5 and "weights &lt;of&gt; a test" in page.decode()
    assert "crosswalk 0.99, where nothing is; picture 3" in page.decode()
    assert re.search(r"a corner 2\.8 px off, said to be within 1\.0 px", page.decode())
    assert len(re.findall(r"data:image/jpeg", page.decode())) >= 9


def test_a_page_without_mistakes_says_so(perfect: Evaluation, report: DetectionReport) -> None:
    page = page_of(perfect, report, "the truth").decode()
    assert page.count("<p>None.</p>") == 2  # corners are shown however little they are off


def test_the_tables_say_the_same_in_text_and_in_markdown(report: DetectionReport) -> None:
    for table in tables(report):
        text, markdown = list(text_lines(table)), list(markdown_lines(table))
        for row in table.rows:
            assert len(row) == len(table.columns)
            assert any(all(cell in line for cell in row) for line in text)
            assert f"| {' | '.join(row)} |" in markdown
    assert "  mAP50-95" in next(line for line in text_lines(tables(report)[0]) if "1.000" in line)


def _fields(one: Detections) -> dict[str, np.ndarray]:
    return {name: getattr(one, name) for name in Detections.__dataclass_fields__}
