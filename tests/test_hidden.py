"""A hidden split from the command line and in the manifest: what is told, and what is not."""

import re
from pathlib import Path

import pytest

from adc_bench.cli.main import main
from adc_bench.dataset import FrameDataset
from adc_bench.dataset.layout import to_toml
from adc_bench.dataset.split import load_split
from adc_bench.errors import InputError
from adc_bench.generate.plan import plan_dataset
from adc_bench.world.salt import VARIABLE, salt_sha256

SALT, OTHER = b"one secret of enough bytes", b"another secret of as many"
HIDDEN = load_split("hidden")


def manifest(salt: bytes) -> str:
    return to_toml(plan_dataset(HIDDEN, 64, (64, 48), salt=salt)).decode()


def test_the_manifest_names_the_salt_and_tells_nothing_else_of_it() -> None:
    first, second = manifest(SALT), manifest(OTHER)
    assert f'salt_sha256 = "{salt_sha256(SALT)}"' in first
    assert first.replace(salt_sha256(SALT), salt_sha256(OTHER)) == second
    assert SALT.decode() not in first and SALT.hex() not in first
    numbers = {int(number) for number in re.findall(r"\b\d+\b", first)}
    assert not numbers & {HIDDEN.seed(k, SALT) for k in range(1000)}


def test_an_open_split_s_manifest_does_not_tell_that_there_is_a_salt() -> None:
    val = load_split("val")
    assert plan_dataset(val, 16, (64, 48), salt=SALT) == plan_dataset(val, 16, (64, 48))


def test_a_hidden_split_without_its_salt_is_refused() -> None:
    with pytest.raises(InputError, match="a salted split, and no salt") as caught:
        plan_dataset(HIDDEN, 64, (64, 48))
    assert "--salt-file" in str(caught.value) and VARIABLE in str(caught.value)


def render(out: Path, *words: str) -> object:
    sized = ("--frames", "2", "--size", "64x48", "--workers", "1")
    with pytest.raises(SystemExit) as ended:
        main(("render", "--split", "hidden", "--out", str(out), *sized, *words))
    return ended.value.code or 0


def test_the_command_wants_a_salt_and_a_long_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert render(tmp_path / "none") == 3
    assert "a salted split, and no salt" in capsys.readouterr().err
    monkeypatch.setenv(VARIABLE, "hunter2")
    assert render(tmp_path / "short") == 3
    told = capsys.readouterr().err
    assert "7 bytes" in told and "at least 16 bytes" in told and "hunter2" not in told
    assert not (tmp_path / "none").exists() and not (tmp_path / "short").exists()


def test_one_salt_makes_one_dataset_from_a_file_or_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    for name, salt in (("salt", SALT), ("other", OTHER)):
        (tmp_path / name).write_bytes(salt + b"\n")
    assert render(tmp_path / "a", "--salt-file", str(tmp_path / "salt")) == 0
    assert render(tmp_path / "c", "--salt-file", str(tmp_path / "other")) == 0
    monkeypatch.setenv(VARIABLE, SALT.decode())
    assert render(tmp_path / "b") == 0
    for path in (tmp_path / "a").rglob("*"):
        if path.is_file():
            data = path.read_bytes()
            assert data == (tmp_path / "b" / path.relative_to(tmp_path / "a")).read_bytes()
            assert SALT not in data
    first, other = (FrameDataset(tmp_path / name) for name in ("a", "c"))
    assert first.jpeg(0) != other.jpeg(0) and first.scenario(0) != other.scenario(0)
