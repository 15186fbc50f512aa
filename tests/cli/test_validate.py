"""What `validate` finds, and what `evaluate submission` makes of submissions that fail."""

import json
import shutil
from pathlib import Path

import pytest

from adc_bench.cli.main import main

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "circle_driver"
TOML = 'name = "mine"\nauthors = ["me"]\nkind = "driver"\nentry = "{}"\n'


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as done:
        main(words)
    told = capsys.readouterr()
    return int(done.value.code or 0), told.out, told.err


def agent(folder: Path, factory: str) -> str:
    shutil.copy(ROOT / "tests" / "evaluate" / "agents.py", folder)
    (folder / "submission.toml").write_text(TOML.format(f"agents:{factory}"))
    return str(folder)


def test_a_sound_submission_passes(capsys: pytest.CaptureFixture[str]) -> None:
    code, told, _ = run(capsys, "validate", str(EXAMPLE), "--json")
    assert code == 0
    checks = {check["name"]: check for check in json.loads(told)}
    assert list(checks) == ["files", "sandbox", "loads", "drives", "repeats", "latency", "output"]
    assert all(checks[name]["ok"] for name in ("files", "loads", "drives", "repeats", "output"))


@pytest.mark.parametrize(
    ("factory", "lines"),
    [
        ("NoStep", ["FAULT  loads       NoStep without step", "         wanted    an object with start(mission)"]),
        ("missing", ["FAULT  loads       no function missing in module agents"]),
        ("RaisesAtSeven", ["FAULT  drives      agent-failed (step-raised) at step 7", "ValueError: seven is too much"]),
        ("NotACommand", ["FAULT  drives      invalid (not-a-command) at step 0: tuple in place of a Command"]),
        ("Random", ["note   repeats     other answers in a second run, from step 0 on"]),
    ],
)
def test_what_is_wrong_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], factory: str, lines: list[str]
) -> None:
    code, told, _ = run(capsys, "validate", agent(tmp_path, factory))
    assert code == (0 if factory == "Random" else 3), told
    for line in lines:
        assert line in told


def test_a_folder_without_submission_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, told, _ = run(capsys, "validate", str(tmp_path))
    assert code == 3
    assert told.startswith("FAULT  loads       a folder without submission.toml")


def test_a_suite_completes_whatever_the_submission_does(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (ROOT / "splits" / "suites" / "dev.toml").read_text()
    suite = tmp_path / "tiny.toml"
    suite.write_text(text.replace("seeds = [6001]", "seeds = [1, 2]").replace("60.0", "0.5", 1))
    words = ("evaluate", "submission", agent(tmp_path, "RaisesAtSeven"), "--suite", str(suite), "--in-process")
    code, told, noted = run(capsys, *words, "--out", str(tmp_path / "out"))
    assert code == 0
    assert told.count("agent-failed (step-raised)") == 2
    assert "the submission is not in a sandbox (--in-process); no leaderboard takes the result" in noted
