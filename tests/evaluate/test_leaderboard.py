"""The leaderboard, fed with result folders of runs made by hand."""

import json
import shutil
from pathlib import Path

import jsonschema
import pytest
from made_runs import along_lap, header_of, log_of

from adc_bench import leaderboard
from adc_bench.cli.main import main
from adc_bench.errors import InputError
from adc_bench.evaluate.log import write_log
from adc_bench.evaluate.results import episode_timing, timing_of, to_json
from adc_bench.evaluate.run import rescore
from adc_bench.evaluate.suite import load_suite

ROOT = Path(__file__).parents[2]


def make_result(folder: Path, name: str, speed_mps: float) -> Path:
    for seed in load_suite("d1").seeds:
        header = header_of(seed=seed, name=name)
        log = log_of(header, along_lap(header, speed_mps))
        write_log(folder / "episodes" / f"{header.scenario}.jsonl", log.header, log.rows, log.ending)
    timing = timing_of({"d1-7001": episode_timing(10.0, 80.0, [0.01])}, 0.0, 0.05)
    (folder / "timing.json").write_bytes(to_json(timing))
    rescore(folder)
    return folder


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    root = tmp_path_factory.mktemp("results")
    return {name: make_result(root / name, name, speed) for name, speed in (("slow", 2.5), ("quick", 3.0))}


@pytest.fixture(scope="module")
def whole_board(tmp_path_factory: pytest.TempPathFactory, results: dict[str, Path]) -> Path:
    root = tmp_path_factory.mktemp("boards") / "board"
    for folder in results.values():
        leaderboard.add(folder, root)
    return root


@pytest.fixture
def board(tmp_path: Path, whole_board: Path) -> Path:
    return Path(shutil.copytree(whole_board, tmp_path / "board"))


def test_entries_are_ranked_by_score_then_by_time(board: Path) -> None:
    ranked = leaderboard.check(board)
    assert [place.entry.submission.name for place in ranked.suites["d1"]] == ["quick", "slow"]
    assert sorted(path.name for path in (board / "entries").iterdir()) == ["quick-d1.json", "slow-d1.json"]
    table = (board / "README.md").read_text()
    assert table.index("| 1 | quick |") < table.index("| 2 | slow |")


def test_adding_again_changes_nothing(board: Path, results: dict[str, Path]) -> None:
    before = {path: path.read_bytes() for path in board.rglob("*") if path.is_file()}
    leaderboard.add(results["slow"], board)
    assert {path: path.read_bytes() for path in board.rglob("*") if path.is_file()} == before


def test_the_export_is_of_the_published_schema(board: Path, tmp_path: Path) -> None:
    out = tmp_path / "leaderboard.json"
    with pytest.raises(SystemExit) as done:
        main(["leaderboard", "export", "--out", str(out), "--leaderboard", str(board)])
    assert done.value.code == 0
    schema, data = json.loads((board / "schema.json").read_text()), json.loads(out.read_text())
    jsonschema.validate(data, schema)
    data["suites"]["d1"][0]["entry"]["runs"] = "five"
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
        ("result.json", '"eligible": true', '"eligible": false', "a result that is not eligible (5 of 5 runs)"),
        ("result.json", '"line_touches": 0', '"line_touches": 1', "figures that the logs do not give"),
        ("result.json", '"planned": 5', '"planned": "5"', "Expected `int`, got `str` - at `$.planned`"),
        ("result.json", '"sha256": "', '"sha256": "f', "rules adc-bench-1 f"),
        ("timing.json", '"isolation"', '"insulation"', "Object contains unknown field `insulation`"),
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


@pytest.mark.parametrize(
    ("name", "old", "new", "found"),
    [
        ("entries/quick-d1.json", '"name": "quick"', '"name": "other"', "a misnamed entry"),
        ("entries/quick-d1.json", '"mean": ', '"average": ', "Object contains unknown field `average`"),
        ("entries/quick-d1.json", '"id": "adc-bench-1"', '"id": "adc-bench-0"', "rules adc-bench-0"),
        ("README.md", "| 1 | quick |", "| 1 | slow |", "another text"),
        ("schema.json", "Leaderboard", "Board", "another text"),
    ],
)
def test_what_check_finds(board: Path, tmp_path: Path, name: str, old: str, new: str, found: str) -> None:
    with pytest.raises(InputError) as caught:
        leaderboard.check(spoil(board, tmp_path, name, old, new))
    assert caught.value.found.startswith(found)


def test_a_missing_leaderboard_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as done:
        main(["leaderboard", "check", "--leaderboard", str(tmp_path / "none")])
    assert done.value.code == 3
    assert "no such folder" in capsys.readouterr().err
