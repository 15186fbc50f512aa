"""The leaderboard, fed with result folders of runs made by hand."""

import hashlib
import json
import shutil
from pathlib import Path

import jsonschema
import pytest
from made_board import make_privileged_result

from adc_bench import leaderboard
from adc_bench.cli.main import main
from adc_bench.errors import InputError
from adc_bench.evaluate.results import to_json
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.run import rescore, result_in
from adc_bench.evaluate.statistics import Statistic, compare
from adc_bench.leaderboard.ranking import places
from adc_bench.leaderboard.records import title

ROOT = Path(__file__).parents[2]


@pytest.fixture
def board(tmp_path: Path, whole_board: Path) -> Path:
    return Path(shutil.copytree(whole_board, tmp_path / "board"))


def files_of(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def statistic(mean: float, low: float, high: float) -> Statistic:
    return Statistic(mean=mean, sd=1.0, median=mean, ci95=(low, high), n=5, unit="", higher_is_better=True)


def test_entries_are_ranked_by_points(board: Path) -> None:
    ranked = leaderboard.check(board).suites["d1"]
    assert [(s.rank, s.submission.name) for s in ranked.standings] == [(1, "quick"), (2, "slow"), (3, "poor")]
    assert sorted(path.name for path in (board / "entries").iterdir()) == [
        "poor-d1.json",
        "quick-d1.json",
        "slow-d1.json",
    ]
    table = (board / "README.md").read_text()
    assert table.index("| 1 | quick |") < table.index("| 2 | slow |") < table.index("| 3 | poor |")


@pytest.mark.parametrize(
    ("figures", "expected"),
    [
        ([], []),
        ([(9, 8, 10), (7, 6, 7.5), (5, 4, 5.5)], [1, 2, 3]),
        ([(9, 8, 10), (7, 6, 8.5), (5, 4, 5.5)], [1, 1, 3]),
        ([(9, 8, 10), (7, 6, 8), (5, 4, 6.5)], [1, 1, 3]),  # the third overlaps the second, but not the first
        ([(5, 5, 5), (5, 5, 5), (4, 4, 4), (4, 4, 4)], [1, 1, 3, 3]),
    ],
)
def test_overlapping_intervals_share_a_place(figures: list[tuple[float, float, float]], expected: list[int]) -> None:
    assert places([statistic(*figure) for figure in figures]) == expected


def test_pairs_compare_the_points_seed_by_seed(board: Path) -> None:
    pairs = leaderboard.check(board).suites["d1"].pairs
    assert [(pair.first, pair.second) for pair in pairs] == [("quick", "slow"), ("quick", "poor"), ("slow", "poor")]
    points = {
        entry.result.submission.name: {episode.seed: episode.points for episode in entry.result.episodes}
        for entry in leaderboard.entries_in(board)
    }
    assert all(pair.difference == compare(points[pair.first], points[pair.second]) for pair in pairs)
    assert pairs[0].difference.mean_difference > 0.0


def test_a_failed_run_counts_with_no_points(board: Path) -> None:
    poor = leaderboard.check(board).suites["d1"].standings[-1]
    assert (poor.runs, poor.failed, poor.summary["points"].n) == (10, 1, 10)
    entry = next(entry for entry in leaderboard.entries_in(board) if entry.name == "poor-d1")
    broken = entry.result.episodes[2]
    assert (broken.status, broken.points, broken.driving_score) == ("agent-failed", 0.0, 0.0)
    assert broken.completion > 0.05


def test_the_verdict_on_the_covariances_stands_beside_the_figures(board: Path) -> None:
    verdicts = [standing.nees for standing in leaderboard.check(board).suites["d1"].standings]
    assert all(nees is not None and nees.n == 10 and nees.low < 3.0 < nees.high for nees in verdicts)


def test_neither_order_nor_adding_again_matters(board: Path, results: dict[str, Path]) -> None:
    before = files_of(board)
    leaderboard.add(results["slow"], board)
    assert files_of(board) == before
    (board / "entries" / "quick-d1.json").unlink()
    leaderboard.add(results["quick"], board)
    assert files_of(board) == before


def test_the_export_is_the_committed_one_and_of_the_published_schema(board: Path, tmp_path: Path) -> None:
    out = tmp_path / "leaderboard.json"
    with pytest.raises(SystemExit) as done:
        main(["leaderboard", "export", "--out", str(out), "--leaderboard", str(board)])
    assert done.value.code == 0
    assert out.read_bytes() == (board / "leaderboard.json").read_bytes()
    schema, data = json.loads((board / "schema.json").read_text()), json.loads(out.read_text())
    jsonschema.validate(data, schema)
    data["suites"]["d1"]["standings"][0]["runs"] = "five"
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(data, schema)


def test_the_shipped_leaderboard_is_sound() -> None:
    leaderboard.check(ROOT / "leaderboard")


def spoil(folder: Path, tmp_path: Path, name: str, old: str, new: str) -> Path:
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    text = (copy / name).read_text()
    assert old in text
    (copy / name).write_text(text.replace(old, new, 1))
    return copy


@pytest.mark.parametrize(
    ("name", "old", "new", "found"),
    [
        ("result.json", '"eligible": true', '"eligible": false', "a result that is not eligible (10 of 10 runs)"),
        ("result.json", '"line_touches": 0', '"line_touches": 1', "figures that the logs do not give"),
        ("result.json", '"planned": 10', '"planned": "10"', "Expected `int`, got `str` - at `$.planned`"),
        ("result.json", '"sha256": "', '"sha256": "f', f"rules {RULES.id} f"),
        ("timing.json", '"isolation"', '"insulation"', "Object contains unknown field `insulation`"),
        ("timing.json", '"bubblewrap"', '"none"', "isolation none"),
        ("timing.json", '"bubblewrap"', '"in-process"', "isolation in-process"),
        ("timing.json", '"within"', '"exceeded"', "steps of 0.010 s (95th percentile)"),
        ("timing.json", '"d1-7004"', '"d1-7000"', "the times of other runs (9 of 10 are the result's)"),
        ("timing.json", '"measured_p95_s": 0.01', '"measured_p95_s": 0.001', "a verdict that the runs' times do not"),
        ("timing.json", '"agent_p95_s": 0.01', '"agent_p95_s": 0.2', "a verdict that the runs' times do not give"),
    ],
)
def test_what_cannot_be_added(
    results: dict[str, Path], tmp_path: Path, name: str, old: str, new: str, found: str
) -> None:
    with pytest.raises(InputError) as caught:
        leaderboard.add(spoil(results["quick"], tmp_path, name, old, new), tmp_path / "board")
    assert caught.value.found.startswith(found)
    assert not (tmp_path / "board").exists()


def test_a_folder_without_timing_cannot_be_added(results: dict[str, Path], tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(results["quick"], copy)
    (copy / "timing.json").unlink()
    with pytest.raises(InputError, match=r"no such file"):
        leaderboard.add(copy, tmp_path / "board")


def test_a_missing_run_cannot_be_added_at_all(results: dict[str, Path], tmp_path: Path) -> None:
    copy = spoil(results["quick"], tmp_path, "result.json", '"completed": 10', '"completed": 9')
    with pytest.raises(InputError, match=r"not eligible \(9 of 10 runs\)"):
        leaderboard.add(copy, tmp_path / "board", unranked=True)


def log_file(folder: Path, seed: int) -> Path:
    return folder / "episodes" / f"d1-{seed}.jsonl"


def refusal(folder: Path, board: Path) -> str:
    """Return why neither the leaderboard nor a new score takes a folder."""
    told = []
    for refused in (lambda: leaderboard.add(folder, board), lambda: rescore(folder)):
        with pytest.raises(InputError) as caught:
            refused()
        told.append(caught.value.found)
    assert told[0] == told[1]
    return told[0]


def test_a_folder_with_a_gap_is_no_result(results: dict[str, Path], tmp_path: Path) -> None:
    copy = Path(shutil.copytree(results["quick"], tmp_path / "copy"))
    log_file(copy, 7004).unlink()
    with pytest.raises(InputError, match="figures that the logs do not give"):
        leaderboard.add(copy, tmp_path / "board")
    result = result_in(copy)
    (copy / "result.json").write_bytes(to_json(result))
    assert (result.status, result.eligible, result.completed) == ("aborted", False, 9)
    for unranked in (False, True):
        with pytest.raises(InputError, match=r"not eligible \(9 of 10 runs\)"):
            leaderboard.add(copy, tmp_path / "board", unranked=unranked)
    (copy / "result.json").unlink()
    assert result_in(copy).planned == 10, "a folder without a result is measured by its suite"


def test_a_run_that_stands_there_twice_is_refused(results: dict[str, Path], tmp_path: Path) -> None:
    copy = Path(shutil.copytree(results["quick"], tmp_path / "copy"))
    log_file(copy, 7004).write_bytes(log_file(copy, 7003).read_bytes())
    assert refusal(copy, tmp_path / "board") == "the log of d1-7003, once more"
    log_file(copy, 7004).unlink()
    log_file(copy, 7011).write_bytes(log_file(copy, 7003).read_bytes())
    assert refusal(copy, tmp_path / "board") == "the log of none of the planned runs"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"software":{"adc_bench":"0"}', '"software":{"adc_bench":"1"}'),
        ('"name":"quick"', '"name":"slick"'),
        (f'"sha256":"{"0" * 64}"', f'"sha256":"{"1" * 64}"'),
        ('"time_limit_s":180.0', '"time_limit_s":181.0'),
        (f'"id":"{RULES.id}"', '"id":"adc-bench-0"'),
    ],
    ids=["software", "submission", "code", "suite", "rules"],
)
def test_runs_of_several_versions_are_refused(old: str, new: str, results: dict[str, Path], tmp_path: Path) -> None:
    """The log is sound in itself: sealed by whoever wrote it."""
    copy = Path(shutil.copytree(results["quick"], tmp_path / "copy"))
    header, *rows, seal = log_file(copy, 7004).read_bytes().splitlines(keepends=True)
    assert old.encode() in header
    other = header.replace(old.encode(), new.encode(), 1)
    whole = json.loads(seal)
    whole["sha256"] = hashlib.sha256(b"".join([other, *rows])).hexdigest()
    log_file(copy, 7004).write_bytes(b"".join([other, *rows, json.dumps(whole).encode(), b"\n"]))
    assert refusal(copy, tmp_path / "board") == "another run than that of d1-7001"


def test_an_unranked_entry_stands_below_without_a_place(board: Path, results: dict[str, Path], tmp_path: Path) -> None:
    """It needs no walls and no speed, and does not move the others."""
    copy = spoil(results["quick"], tmp_path, "timing.json", '"bubblewrap"', '"none"')
    leaderboard.add(copy, board, unranked=True)
    ranked = leaderboard.check(board).suites["d1"].standings
    assert [(s.rank, s.submission.name) for s in ranked] == [(1, "slow"), (2, "poor"), (None, "quick")]
    assert "| - | quick |" in (board / "README.md").read_text()


def test_a_driver_with_a_layer_of_truth_is_an_entry_of_its_own(board: Path, tmp_path: Path) -> None:
    lent = make_privileged_result(tmp_path / "lent", "poor")
    with pytest.raises(InputError, match="not eligible"):
        leaderboard.add(lent, board)
    leaderboard.add(lent, board, unranked=True)
    names = [title(standing.submission) for standing in leaderboard.check(board).suites["d1"].standings]
    assert names == ["quick", "slow", "poor", "poor with true pose"]
    leaderboard.write_site(board, tmp_path / "site")
    page, other = ((tmp_path / "site" / "entries" / f"{name}-d1.html").read_text() for name in ("poor", "quick"))
    assert "<h2>Ladder</h2>" in page and '<a href="poor+pose-d1.html">pose</a>' in page
    assert "Ladder" not in other and (tmp_path / "site" / "entries" / "poor+pose-d1.html").is_file()


@pytest.mark.parametrize(
    ("name", "old", "new", "found"),
    [
        ("entries/quick-d1.json", '"name": "quick"', '"name": "other"', "a misnamed entry"),
        ("entries/quick-d1.json", '"mean": ', '"average": ', "Object contains unknown field `average`"),
        ("entries/quick-d1.json", f'"id": "{RULES.id}"', '"id": "adc-bench-0"', "rules adc-bench-0"),
        ("entries/quick-d1.json", '"seed": 7002', '"seed": 7001', "other runs than the suite's"),
        ("entries/quick-d1.json", '"points": ', '"points": 9', "a summary that its runs do not give"),
        ("entries/quick-d1.json", '"mean": ', '"mean": 9', "a summary that its runs do not give"),
        ("traces/quick-d1.jsonl", '"x_mm":[-650', '"x_mm":[-651', "other traces than those of the entry"),
        ("README.md", "| 1 | quick |", "| 1 | slow |", "another text"),
        ("leaderboard.json", '"rank": 1', '"rank": 2', "another text"),
        ("schema.json", "Leaderboard", "Board", "another text"),
    ],
)
def test_what_check_finds(board: Path, tmp_path: Path, name: str, old: str, new: str, found: str) -> None:
    with pytest.raises(InputError) as caught:
        leaderboard.check(spoil(board, tmp_path, name, old, new))
    assert caught.value.found.startswith(found)


def test_check_misses_missing_traces(board: Path) -> None:
    (board / "traces" / "quick-d1.jsonl").unlink()
    with pytest.raises(InputError, match="no such file"):
        leaderboard.check(board)


def test_an_entry_of_other_rules_stops_others_but_not_its_own_renewal(board: Path, results: dict[str, Path]) -> None:
    path = board / "entries" / "quick-d1.json"
    path.write_text(path.read_text().replace(RULES.id, "adc-bench-0"))
    before = files_of(board)
    with pytest.raises(InputError, match=r"quick-d1\.json"):
        leaderboard.add(results["slow"], board)
    assert files_of(board) == before
    leaderboard.add(results["quick"], board)
    leaderboard.check(board)


def test_a_missing_leaderboard_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as done:
        main(["leaderboard", "check", "--leaderboard", str(tmp_path / "none")])
    assert done.value.code == 3
    assert "no such folder" in capsys.readouterr().err
