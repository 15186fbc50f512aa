"""Scores of runs over recordings made by hand, and their place on a leaderboard."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

import jsonschema
import msgspec
import numpy as np
import pytest
from made_board import written
from made_recordings import few_pictures, label, pictures_log, straight_log

from adc_bench import leaderboard
from adc_bench.api import Detection
from adc_bench.detector.evaluation.score import CocoScorer
from adc_bench.errors import InputError
from adc_bench.evaluate.detection_score import DetectionEpisode, detections_of, score_detections
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.localization_score import score_localization
from adc_bench.evaluate.log import DetectionLog
from adc_bench.evaluate.recorded_suite import DetectionSuite, LocalizationSuite
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.run import rescore
from adc_bench.evaluate.suite import load_suite, rules_id
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID

LOC, DET = load_suite("loc"), load_suite("det")
assert isinstance(LOC, LocalizationSuite) and isinstance(DET, DetectionSuite)
PICTURES = few_pictures(4, 2)
SIGN, BOX = CATEGORY_ID["sign_dip"], CATEGORY_ID["box"]
LABELS = [
    [label(SIGN, (10.0, 10.0, 50.0, 50.0)), label(BOX, (60.0, 60.0, 90.0, 90.0), corners=False)],
    [label(SIGN, (100.0, 20.0, 160.0, 70.0))],
    [],
    [label(BOX, (5.0, 100.0, 60.0, 150.0), corners=False)],
]


def answers(score: float = 0.9, off_px: float = 0.0, corners: bool = True) -> list[list[Detection]]:
    """Return what a detector says that finds all, its corners so far to the right of the true ones."""
    return [
        [
            Detection(
                category=CATEGORIES[each.category_id - 1],
                score=score,
                box_px=each.box_px,
                corners_px=tuple((u + off_px, v) for u, v, _ in each.keypoints_px)
                if corners and each.category_id == SIGN
                else None,
            )
            for each in of_picture
        ]
        for of_picture in LABELS
    ]


def test_an_estimate_off_by_so_much_has_that_error() -> None:
    errors = score_localization(straight_log(LOC, "a", LOC.seeds[0], 0.03)).localization
    assert errors is not None
    figures = (errors.position_rmse_m, errors.position_p95_m, errors.position_max_m, errors.nees_mean)
    assert figures == pytest.approx((0.03, 0.03, 0.03, (0.03 / 0.02) ** 2))
    assert errors.ate_rmse_m == pytest.approx(0.0, abs=1e-9)
    assert errors.coverage == 1.0
    sure = score_localization(straight_log(LOC, "a", LOC.seeds[0], 0.03, sigma_m=None)).localization
    assert sure is not None and sure.nees_mean is None and sure.coverage is None


def test_a_localiser_that_fails_is_worth_who_never_left() -> None:
    """However well it did before, and wherever it broke."""
    log = straight_log(LOC, "a", LOC.seeds[0], 0.0, reason=Reason.STEP_RAISED)
    silent = tuple(msgspec.structs.replace(row, answer=None) for row in log.rows[30:])
    for rows in (log.rows, (*log.rows[:30], *silent)):
        episode = score_localization(msgspec.structs.replace(log, rows=rows))
        assert episode.failed and episode.localization is not None
        way_m = 0.05 * np.arange(len(rows))
        assert episode.localization.position_rmse_m == pytest.approx(math.sqrt(np.mean(way_m**2)))
        assert episode.localization.nees_mean is None
    finished = msgspec.structs.replace(log, ending=msgspec.structs.replace(log.ending, reason=Reason.FINISHED))
    assert score_localization(finished).localization.position_rmse_m == 0.0


def test_a_recording_that_this_machine_lost_has_no_errors() -> None:
    log = straight_log(LOC, "a", LOC.seeds[0], 0.0, reason=Reason.HOST)
    assert score_localization(msgspec.structs.replace(log, rows=())).localization is None


def test_who_finds_all_has_a_perfect_score() -> None:
    episode = scored(pictures_log(PICTURES, "a", PICTURES.seeds[0], LABELS, answers(off_px=3.0)))
    found = episode.detection
    assert (episode.pictures, episode.objects) == (4, 4)
    assert (found.map, found.map50, found.precision, found.recall) == (1.0, 1.0, 1.0, 1.0)
    assert found.corner_error_px == pytest.approx(3.0)
    assert set(found.categories) == {"sign_dip", "box"}


def test_average_precision_is_coco_s_and_the_rest_is_of_what_is_believed() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        said = [
            [msgspec.structs.replace(each, score=float(rng.random()), box_px=moved(each.box_px, rng)) for each in some]
            for some in answers()
        ]
        said[2] = [Detection(category="cone", score=float(rng.random()), box_px=(0.0, 0.0, 9.0, 9.0))]
        found = scored(pictures_log(PICTURES, "a", PICTURES.seeds[0], LABELS, said)).detection
        other = CocoScorer(range(4), LABELS, [detections_of(each) for each in said]).score()
        assert (found.map, found.map50) == (other.map, other.map50)
        believed = [each for some in said for each in some if each.score >= RULES.believed_score]
        assert (found.precision is None) == (not believed)
    quiet = scored(pictures_log(PICTURES, "a", PICTURES.seeds[0], LABELS, answers(score=0.4))).detection
    assert (quiet.map, quiet.precision, quiet.recall, quiet.corner_error_px) == (1.0, None, 0.0, None)
    plain = scored(pictures_log(PICTURES, "a", PICTURES.seeds[0], LABELS, answers(corners=False))).detection
    assert (plain.map, plain.recall, plain.corner_error_px) == (1.0, 1.0, None)


def scored(log: DetectionLog) -> DetectionEpisode:
    return score_detections([log])[0]


def test_the_mean_of_the_shares_is_the_figure_of_all_pictures() -> None:
    rng = np.random.default_rng(4)
    logs, labels, found = [], [], []
    for seed in DET.seeds:
        said = [
            [
                msgspec.structs.replace(each, score=float(rng.random()), box_px=moved(each.box_px, rng, 20.0))
                for each in some
            ]
            for some in answers(off_px=float(rng.random()))
        ]
        logs.append(pictures_log(DET, "a", seed, LABELS, said))
        labels += LABELS
        found += [detections_of(each) for each in said]
    episodes, whole = score_detections(logs), CocoScorer(range(len(labels)), labels, found).score()
    for name in ("map", "map50"):
        shares = [getattr(episode.share, name) for episode in episodes]
        assert np.mean(shares) == pytest.approx(getattr(whole, name)) and np.std(shares) > 0
    assert whole.map != pytest.approx(np.mean([episode.detection.map for episode in episodes]), abs=1e-3)
    recalls = [(episode.share.recall, episode.detection.recall) for episode in episodes]
    assert np.allclose(*zip(*recalls, strict=True)), "a mean over equal numbers of objects is its own share"


def test_one_set_is_the_whole() -> None:
    episode = scored(pictures_log(PICTURES, "a", PICTURES.seeds[0], LABELS, answers(off_px=2.0)))
    assert episode.share.map == episode.detection.map
    assert episode.share.corner_error_px == episode.detection.corner_error_px


def moved(box: Sequence[float], rng: np.random.Generator, far_px: float = 6.0) -> tuple[float, ...]:
    return tuple(float(value) for value in np.array(box) + rng.uniform(-far_px, far_px, 4))


def test_a_detector_that_fails_has_found_nothing() -> None:
    log = pictures_log(PICTURES, "a", PICTURES.seeds[0], LABELS, answers(), reason=Reason.NOT_DETECTIONS)
    episode = scored(log)
    assert episode.failed
    assert (episode.detection.map, episode.detection.precision, episode.detection.recall) == (0.0, None, 0.0)


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two localisers, one of which failed once, and two detectors."""
    root = tmp_path_factory.mktemp("recorded")
    for name, error_m, broken in (("near", 0.01, False), ("far", 0.2, False), ("frail", 0.01, True)):
        logs = [straight_log(LOC, name, seed, error_m + 0.001 * k) for k, seed in enumerate(LOC.seeds)]
        if broken:
            ending = msgspec.structs.replace(logs[0].ending, reason=Reason.DIED)
            logs[0] = msgspec.structs.replace(logs[0], ending=ending)
        leaderboard.add(written(root / name, logs), root / "board")
    for name, off in (("keen", 0.0), ("dull", 60.0)):
        said = [
            [msgspec.structs.replace(each, box_px=tuple(v + off for v in each.box_px)) for each in some]
            for some in answers()
        ]
        pictures = [pictures_log(DET, name, seed, LABELS, said) for seed in DET.seeds]
        leaderboard.add(written(root / name, pictures), root / "board")
    return root / "board"


def test_each_kind_is_ranked_by_its_own_figure(board: Path) -> None:
    ranked = leaderboard.check(board)
    loc, det = ranked.suites["loc"], ranked.suites["det"]
    assert (loc.kind, loc.ranked_by, det.kind, det.ranked_by) == ("localizer", "position_rmse_m", "detector", "map")
    standings = [(s.rank, s.submission.name, s.failed) for s in loc.standings]
    assert standings == [(1, "near", 0), (1, "frail", 1), (3, "far", 0)]
    assert [(s.rank, s.submission.name) for s in det.standings] == [(1, "keen"), (2, "dull")]
    assert [(p.first, p.second) for p in det.pairs] == [("keen", "dull")]
    assert det.pairs[0].difference.mean_difference == pytest.approx(1.0)
    assert all(standing.nees is not None for standing in loc.standings if standing.submission.name != "frail")
    assert all(standing.nees is None for standing in det.standings)
    data = json.loads((board / "leaderboard.json").read_text())
    jsonschema.validate(data, json.loads((board / "schema.json").read_text()))
    table = (board / "README.md").read_text()
    assert (
        "| rank | submission | mAP [%] | AP50 [%] |" in table and "| rank | submission | position RMSE [m] |" in table
    )


def test_the_site_has_a_page_for_each_kind(board: Path, tmp_path: Path) -> None:
    assert leaderboard.write_site(board, tmp_path / "site") == 6
    index = (tmp_path / "site" / "index.html").read_text()
    assert "recorded drives, to be located in" in index and "of 40 pictures" in index
    pages = {name: (tmp_path / "site" / "entries" / f"{name}.html").read_text() for name in ("near-loc", "keen-det")}
    assert 'id="run-loc-' in pages["near-loc"] and "Replay" in pages["near-loc"]
    assert "Replay" not in pages["keen-det"] and "<td>100.0 %</td>" in pages["keen-det"]


def test_what_was_changed_afterwards_is_found(board: Path) -> None:
    folder = board.parent / "keen"
    entry = next(entry for entry in leaderboard.entries_in(board) if entry.name == "keen-det")
    assert rescore(folder) == entry.result and entry.traces_sha256 is None
    text = (folder / "result.json").read_text()
    (folder / "result.json").write_text(text.replace('"map": 1.0', '"map": 1.1', 1))
    with pytest.raises(InputError, match="figures that the logs do not give"):
        leaderboard.add(folder, board.parent / "other")
    (folder / "result.json").write_text(text)


def test_the_digest_covers_split_rules_and_named_layouts() -> None:
    ids = [rules_id(LOC), rules_id(DET), rules_id(LOC, msgspec.structs.replace(RULES, believed_score=0.6))]
    ids.append(rules_id(msgspec.structs.replace(DET, split=msgspec.structs.replace(DET.split, seed_first=1))))
    assert len({each.sha256 for each in ids}) == 4


def test_suites_of_recordings_have_seeds_of_their_own() -> None:
    assert len(LOC.seeds) == len(DET.seeds) == 10
    assert LOC.split.seed_first > 3_600_000 and not set(LOC.seeds) & set(DET.seeds)
    arenas = DET.pictures // DET.split.frames_per_scenario
    assert DET.seeds == tuple(range(DET.split.seed_first, DET.split.seed_first + 10 * arenas, arenas))


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("pictures = 40", "pictures = 41", "pictures must be a multiple of frames_per_scenario, and frames one"),
        ("pictures = 40", 'pictures = 40\nsalt_sha256 = "0"', "split.salted must be true where there is a salt_sha256"),
        ("frames = 400\n", "", "Object missing required field `frames` - at `$.split`"),
        ('kind = "detector"', 'kind = "painter"', "Invalid enum value 'painter' - at `$.kind`"),
        ("d3_v1 = ", "d3_v9 = ", "an unknown name"),
    ],
)
def test_what_is_wrong_with_a_suite_is_told(tmp_path: Path, old: str, new: str, found: str) -> None:
    text = (Path(__file__).parents[2] / "splits" / "suites" / "det.toml").read_text()
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_suite(str(path))
    assert found in caught.value.found
