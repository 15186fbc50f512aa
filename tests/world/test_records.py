from pathlib import Path

import msgspec
import pytest

from adc_bench.errors import InputError
from adc_bench.world.records import find_record, known_records, load_record


class Recipe(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    name: str
    count: int = 3


def write(folder: Path, text: str) -> Path:
    path = folder / "recipe.toml"
    path.write_text(text)
    return path


def test_a_record_is_read(tmp_path: Path) -> None:
    assert load_record(write(tmp_path, 'name = "a"'), Recipe) == Recipe(name="a")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("name = ", "broken TOML: Invalid value (at end of document)"),
        ('name = "a"\nnumber = 2', "Object contains unknown field `number`"),
        ('name = "a"\ncount = "b"', "Expected `int`, got `str` - at `$.count`"),
        ("count = 2", "Object missing required field `name`"),
    ],
)
def test_what_is_wrong_with_a_record_is_told(tmp_path: Path, text: str, found: str) -> None:
    with pytest.raises(InputError) as caught:
        load_record(write(tmp_path, text), Recipe)
    assert caught.value.found == found
    assert caught.value.where == str(tmp_path / "recipe.toml")
    assert caught.value.wanted == "TOML with the keys name, count"
    assert caught.value.exit_code == 3


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No such file"):
        load_record(tmp_path / "none.toml", Recipe)


def test_suites_are_found_by_name_and_by_path(tmp_path: Path) -> None:
    path = find_record("d1", "splits/suites")
    assert path.name == "d1.toml"
    assert find_record(str(path), "splits/suites") == path
    assert {"d1", "dev"} <= set(known_records("splits/suites"))


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(InputError) as caught:
        find_record("d9", "splits/suites")
    assert caught.value.where == "suite 'd9'"
    assert caught.value.wanted.startswith("one of ") and "d1, d2, d3" in caught.value.wanted
