"""A hidden suite from the command line: what is published, and what binds the organiser to it."""

from pathlib import Path

import msgspec
import pytest

from adc_bench.cli.main import main
from adc_bench.errors import InputError
from adc_bench.evaluate.hidden_suite import hide_suite
from adc_bench.evaluate.suite import check_salt, load_suite, rules_id, scenario_for
from adc_bench.world.records import find_record, known_records
from adc_bench.world.salt import VARIABLE, salt_sha256

SALT, OTHER = b"one secret of enough bytes", b"another secret of as many"


def hide(*words: str) -> object:
    with pytest.raises(SystemExit) as ended:
        main(["hide", *words])
    return ended.value.code


def test_the_command_writes_a_suite_that_only_its_salt_drives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    (tmp_path / "salt.txt").write_bytes(SALT + b"\n")
    out = tmp_path / "d1-final.toml"
    assert hide("d1", "--salt-file", str(tmp_path / "salt.txt"), "--out", str(out)) == 0
    assert capsys.readouterr().out == f"{out}: suite d1-final, salt sha256 {salt_sha256(SALT)}\n"
    assert SALT not in out.read_bytes()
    hidden, open_one = load_suite(str(out)), load_suite("d1")
    assert hidden == msgspec.structs.replace(open_one, name="d1-final", salt_sha256=salt_sha256(SALT))
    assert scenario_for(hidden, 7001, salt=SALT).look != scenario_for(open_one, 7001).look
    check_salt(hidden, SALT)
    with pytest.raises(InputError, match="a salt with the digest"):
        check_salt(hidden, OTHER)


def test_another_salt_is_another_suite_in_every_result(tmp_path: Path) -> None:
    suites = []
    for folder, salt in (("a", SALT), ("b", OTHER), ("c", SALT)):
        hide_suite("d1", salt, tmp_path / folder / "final.toml")
        suites.append(load_suite(str(tmp_path / folder / "final.toml")))
    first, other, again = (rules_id(suite).sha256 for suite in suites)
    assert first == again != other


@pytest.mark.parametrize("name", known_records("splits/suites"))
def test_every_suite_can_be_hidden_and_keeps_its_words(name: str, tmp_path: Path) -> None:
    hide_suite(name, SALT, tmp_path / "final.toml")
    before = find_record(name, "splits/suites").read_text().splitlines()
    after = (tmp_path / "final.toml").read_text().splitlines()
    added = ["salted = true"] if "[split]" in before else []
    told = ['name = "final"', f'salt_sha256 = "{salt_sha256(SALT)}"', *added]
    assert [line for line in after if line not in before] == told
    assert load_suite(str(tmp_path / "final.toml")).seeds == load_suite(name).seeds


@pytest.mark.parametrize(
    ("source", "name", "found"),
    [
        ("d1", "d1.toml", "the name 'd1.toml'"),
        ("d1", "final", "the name 'final'"),
        ("d1", "My Finals.toml", "the name 'My Finals.toml'"),
        ("d9", "final.toml", "an unknown name"),
    ],
)
def test_what_cannot_be_hidden_is_told(source: str, name: str, found: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        hide_suite(source, SALT, tmp_path / name)
    assert caught.value.found == found
    assert not list(tmp_path.iterdir())


def test_what_is_hidden_is_not_hidden_again(tmp_path: Path) -> None:
    hide_suite("d1", SALT, tmp_path / "final.toml")
    with pytest.raises(InputError, match="a hidden suite"):
        hide_suite(str(tmp_path / "final.toml"), OTHER, tmp_path / "other.toml")


def test_without_a_salt_it_says_how_to_make_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert hide("d1", "--out", str(tmp_path / "final.toml")) == 3
    told = capsys.readouterr().err
    assert "no salt" in told and "openssl rand" in told
