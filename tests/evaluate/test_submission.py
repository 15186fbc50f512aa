from pathlib import Path

import pytest

from adc_bench.errors import InputError
from adc_bench.evaluate.submission import digest, load_submission

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
        (TOML.replace('entry = "agent:make"\n', ""), "Object missing required field `entry`"),
        ("name = ", "broken TOML: Invalid value"),
    ],
)
def test_what_is_wrong_with_submission_toml_is_told(tmp_path: Path, text: str, found: str) -> None:
    with pytest.raises(InputError) as caught:
        load_submission(str(folder_with(tmp_path, text)), {})
    assert found in caught.value.found
    assert caught.value.where == str(tmp_path / "submission.toml")
