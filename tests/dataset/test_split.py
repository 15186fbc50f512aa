import tomllib
from itertools import combinations, pairwise
from pathlib import Path

import msgspec
import pytest

from adc_bench.dataset import Split, load_split
from adc_bench.errors import InputError
from adc_bench.world.records import splits_folder

NAMES = ("train", "val", "test")


def test_seed_ranges_do_not_meet() -> None:
    ranges = sorted((s.seed_first, s.seed_first + s.seed_count) for s in map(load_split, NAMES))
    assert all(end <= start for (_, end), (start, _) in pairwise(ranges))


def test_suites_drive_on_seeds_of_no_split() -> None:
    splits = [load_split(name) for name in NAMES]
    for path in (splits_folder() / "suites").glob("*.toml"):
        for seed in tomllib.loads(path.read_text())["seeds"]:
            assert not any(0 <= seed - split.seed_first < split.seed_count for split in splits)


@pytest.mark.parametrize("kind", ["floors", "walls", "light_sets"])
def test_looks_do_not_meet(kind: str) -> None:
    for a, b in combinations(NAMES, 2):
        first, second = getattr(load_split(a).looks, kind), getattr(load_split(b).looks, kind)
        assert first and second and not set(first) & set(second)


def test_digest_follows_the_values_alone() -> None:
    split = load_split("val")
    assert split.sha256 == load_split("val").sha256
    assert split.sha256 != msgspec.structs.replace(split, signs_share=0.3).sha256


def test_unknown_split_lists_the_known() -> None:
    with pytest.raises(InputError) as caught:
        load_split("nope")
    assert caught.value.exit_code == 3
    assert all(name in str(caught.value) for name in ("nope", *NAMES))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("frames = 640", "frams = 640", "frams"),
        ("frames = 640", 'frames = "many"', "$.frames"),
        ("frames = 640", "frames = 0", "frames must lie in 1..1600000"),
        ("objects_share = 0.3", "objects_share = 0.6", "the sum of the last two must lie in 0..1"),
        ("random_works = 0.125", "random_works = 0.5", "the shares in layouts must be more than 0 and add up to 1"),
        ("signs_share = 0.8", 'course = "c"', "Invalid enum value 'c' - at `$.course`"),
        ("signs_share = 0.8", 'robot = "segway"', "Invalid enum value 'segway' - at `$.robot`"),
        ('"worn_vinyl"', '"lawn"', "looks.floors has the unknown name 'lawn'"),
        ('["dark", "dim", "normal", "bright"]', "[]", "looks.light_levels is empty"),
        ('name = "val"', 'name = "val', "broken TOML"),
    ],
)
def test_broken_split_is_told_with_its_place(tmp_path: Path, old: str, new: str, told: str) -> None:
    text = (splits_folder() / "val.toml").read_text()
    assert old in text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_split(str(path))
    assert told in str(caught.value) and str(path) in str(caught.value)


def test_an_unknown_layout_of_a_split_lists_the_known(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text((splits_folder() / "val.toml").read_text().replace("random_works", "d9"))
    with pytest.raises(InputError) as caught:
        load_split(str(path))
    assert caught.value.where == "layout 'd9'"
    assert all(name in caught.value.wanted for name in ("d3_v1", "d4_v2", "open", "random_works"))


def test_the_digest_does_not_hang_on_the_order_of_layouts() -> None:
    split = load_split("val")
    turned = msgspec.structs.replace(split, layouts=dict(reversed(split.layouts.items())))
    assert turned.sha256 == split.sha256


def test_a_split_of_ones_own_is_read_by_path(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text((splits_folder() / "val.toml").read_text().replace('"val"', '"mine"'))
    assert isinstance(load_split(str(path)), Split) and load_split(str(path)).name == "mine"
