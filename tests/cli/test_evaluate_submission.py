from pathlib import Path

import pytest

from adc_bench.cli.evaluate_submission import parse_options
from adc_bench.cli.main import main
from adc_bench.errors import UsageError

EXAMPLE = Path(__file__).parents[2] / "examples" / "circle_driver"


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as done:
        main(words)
    told = capsys.readouterr()
    return int(done.value.code or 0), told.out, told.err


def test_the_example_is_driven_and_scored(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    code, told, _ = run(capsys, "evaluate", "submission", str(EXAMPLE), "--suite", "dev", "--out", str(out))
    assert code == 0
    assert "dev-6001: success (off-road), no lap" in told
    result = (out / "result.json").read_bytes()
    code, told, _ = run(capsys, "rescore", str(out), "--json")
    assert code == 0
    assert told.encode() == result == (out / "result.json").read_bytes()
    assert (out / "paths.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (("nobody", "--suite", "d1"), 3, "no such folder"),
        ((str(EXAMPLE), "--suite", "d77"), 3, "wanted:     one of b1, b2, d1"),
        ((str(EXAMPLE), "--suite", "d1", "--set", "weights"), 2, "'weights'"),
    ],
)
def test_what_cannot_be_driven(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], code: int, text: str
) -> None:
    found, _, told = run(capsys, "evaluate", "submission", *words, "--out", str(tmp_path / "out"))
    assert found == code
    assert text in told
    assert not (tmp_path / "out").exists()


def test_rescoring_an_empty_folder_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, told = run(capsys, "rescore", str(tmp_path))
    assert code == 3
    assert "no episode log" in told


def test_options_are_parsed() -> None:
    assert parse_options(["a=1", "b=x=y"]) == {"a": "1", "b": "x=y"}
    for texts in (["=1"], ["a"], ["a=1", "a=2"]):
        with pytest.raises(UsageError):
            parse_options(texts)
