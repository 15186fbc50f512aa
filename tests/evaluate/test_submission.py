import shutil
import tomllib
from pathlib import Path

import pytest

from adc_bench.api import Kind
from adc_bench.errors import InputError, UsageError
from adc_bench.evaluate.submission import NOT_DRIVING, PACKAGE, load_submission, require_kind
from adc_bench.evaluate.submission_files import digest, stage

TOML = 'name = "mine"\nauthors = ["me"]\nkind = "driver"\nentry = "agent:make"\n'


def folder_with(tmp_path: Path, text: str = TOML) -> Path:
    (tmp_path / "submission.toml").write_text(text)
    (tmp_path / "agent.py").write_text("")
    return tmp_path


def test_a_folder_is_a_submission(tmp_path: Path) -> None:
    submission = load_submission(str(folder_with(tmp_path)), {"speed": "1"})
    assert (submission.id.name, submission.id.authors, submission.id.latency_s) == ("mine", ("me",), 0.0)
    assert submission.id.options == {"speed": "1"}
    assert (submission.load.folder, submission.load.entry) == (str(tmp_path), "agent:make")
    assert len(submission.id.sha256) == 64


def test_the_digest_follows_the_files(tmp_path: Path) -> None:
    folder = folder_with(tmp_path)
    before = digest(folder, {})
    (folder / "__pycache__").mkdir()
    (folder / "__pycache__" / "agent.pyc").write_text("compiled")
    (folder / ".hidden").write_text("x")
    assert digest(folder, {}) == before
    (folder / "agent.py").write_text("x = 1")
    assert digest(folder, {}) != before


def test_the_digest_follows_the_files_that_options_name(tmp_path: Path) -> None:
    folder = folder_with(tmp_path)
    weights = tmp_path.parent / f"{tmp_path.name}-weights"
    weights.write_bytes(b"1")
    first = load_submission(str(folder), {"weights": str(weights)})
    weights.write_bytes(b"2")
    assert load_submission(str(folder), {"weights": str(weights)}).id.sha256 != first.id.sha256


def test_files_in_options_reach_the_agent_by_their_full_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder_with(tmp_path)
    monkeypatch.chdir(tmp_path)
    submission = load_submission(".", {"weights": "agent.py", "mode": "x"})
    assert submission.load.options == {"weights": str(tmp_path / "agent.py"), "mode": "x"}
    assert submission.id.options == {"weights": "agent.py", "mode": "x"}


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (TOML + "speed = 2\n", "Object contains unknown field `speed`"),
        (TOML.replace("driver", "painter"), "Invalid enum value 'painter' - at `$.kind`"),
        (TOML.replace("agent:make", "agent.make"), "Expected `str` matching regex"),
        (TOML.replace('"mine"', '"My Own"'), "Expected `str` matching regex"),
        (TOML + "latency_s = -1.0\n", "Expected `float` >= 0.0 - at `$.latency_s`"),
        (TOML.replace('entry = "agent:make"\n', ""), "neither entry nor command"),
        (TOML + 'command = ["./drive"]\n', "both entry and command"),
        (TOML.replace('entry = "agent:make"', "command = []"), "Expected `array` of length >= 1 - at `$.command`"),
        ("name = ", "broken TOML: Invalid value"),
    ],
)
def test_what_is_wrong_with_submission_toml_is_told(tmp_path: Path, text: str, found: str) -> None:
    with pytest.raises(InputError) as caught:
        load_submission(str(folder_with(tmp_path, text)), {})
    assert found in caught.value.found
    assert caught.value.where == str(tmp_path / "submission.toml")


def test_a_command_is_a_submission_too(tmp_path: Path) -> None:
    text = TOML.replace('entry = "agent:make"', 'command = ["./drive", "--fast"]')
    submission = load_submission(str(folder_with(tmp_path, text)), {})
    assert submission.load.command == ("./drive", "--fast")
    assert submission.load.name == "./drive --fast"


@pytest.mark.parametrize(
    ("kind", "suite"), [("localizer", "driver"), ("detector", "localizer"), ("driver", "detector")]
)
def test_a_suite_is_for_one_kind(tmp_path: Path, kind: Kind, suite: Kind) -> None:
    submission = load_submission(str(folder_with(tmp_path, TOML.replace("driver", kind))), {})
    require_kind(submission, kind)
    with pytest.raises(InputError) as caught:
        require_kind(submission, suite)
    assert caught.value.found == f"kind = '{kind}'"
    assert caught.value.wanted == f"kind = '{suite}', which this suite is for"


@pytest.mark.parametrize(
    ("kind", "names"),
    [("localizer", "odometry-only, reference, thesis"), ("detector", "reference")],
)
def test_a_built_in_one_is_known_by_kind(kind: Kind, names: str) -> None:
    submission = load_submission("reference", {}, kind=kind)
    assert (submission.id.kind, submission.load.kind, submission.load.folder) == (kind, kind, None)
    with pytest.raises(InputError) as caught:
        load_submission("stand-still", {}, kind=kind)
    assert caught.value.wanted.endswith(f"one of {names}")
    with pytest.raises(UsageError, match="the truth is lent to no other"):
        load_submission("reference", {}, "pose", kind)


def test_a_symbolic_link_could_name_any_file_and_is_refused(tmp_path: Path) -> None:
    folder = folder_with(tmp_path)
    (folder / "data").mkdir()
    (folder / "data" / "passwords").symlink_to("/etc/passwd")
    with pytest.raises(InputError) as caught:
        load_submission(str(folder), {})
    assert caught.value.found == "a symbolic link"
    assert caught.value.where.endswith("data/passwords")


def test_a_run_gets_the_files_of_the_digest_and_no_others(tmp_path: Path) -> None:
    folder, copy = tmp_path / "mine", tmp_path / "copy"
    for made in (folder, copy):
        made.mkdir()
    folder_with(folder)
    (folder / "tool").write_text("#!/bin/sh")
    (folder / "tool").chmod(0o700)
    (folder / "__pycache__").mkdir()
    (folder / "__pycache__" / "agent.cpython-311.pyc").write_bytes(b"another program")
    (folder / ".git").write_text("x")
    sha256 = digest(folder, {})
    stage(folder, copy, {}, sha256)
    modes = {path.name: path.stat().st_mode & 0o777 for path in copy.iterdir()}
    assert modes == {"submission.toml": 0o644, "agent.py": 0o644, "tool": 0o755}
    (folder / "agent.py").write_text("changed = 1")
    with pytest.raises(InputError, match="other files than when the run began"):
        stage(folder, copy, {}, sha256)


def test_a_built_in_drivers_digest_is_of_what_can_drive(tmp_path: Path) -> None:
    """The page of a site changes nothing of a drive; a line of the driver may change everything."""
    copy = tmp_path / "adc_bench"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "splits").mkdir(exist_ok=True)
    for name in ("cli/main.py", "leaderboard/site/style.css", "reproduce/page.py", "splits/d1.toml"):
        (copy / name).write_text("changed")
    assert digest(copy, {}, NOT_DRIVING) == load_submission("stand-still", {}).id.sha256
    (copy / "stack" / "stand_still.py").write_text("changed")
    assert digest(copy, {}, NOT_DRIVING) != load_submission("stand-still", {}).id.sha256


def test_what_a_digest_leaves_out_no_drive_can_reach() -> None:
    contracts = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    layers = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    above = " | ".join(layers[: layers.index("adc_bench.evaluate")]).split(" | ")
    assert {f"adc_bench.{room}" for room in NOT_DRIVING} == {*above, "adc_bench.splits"}
