import tomllib
from collections.abc import Iterator
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import msgspec
import pytest

from adc_bench.dataset import Split, load_split
from adc_bench.dataset.sampling import draw_scenario, layout_name
from adc_bench.errors import InputError
from adc_bench.world.course import COURSE_SETS, Course
from adc_bench.world.look import ARTWORKS, draw_look
from adc_bench.world.records import known_records, splits_folder
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import RANDOM_LAYOUTS, draw_layout
from adc_bench.world.streams import stream

NAMES = ("train", "val", "test")
SALT, OTHER_SALT = b"sixteen bytes at the least", b"another secret of enough bytes"
RIG = SensorRig()


def test_seed_ranges_do_not_meet() -> None:
    ranges = sorted((s.seed_first, s.seed_first + s.seed_count) for s in map(load_split, (*NAMES, "negatives")))
    assert all(end <= start for (_, end), (start, _) in pairwise(ranges))


def test_suites_drive_on_seeds_of_no_split() -> None:
    splits = [load_split(name) for name in (*NAMES, "negatives")]
    ranges = [range(split.seed_first, split.seed_first + split.seed_count) for split in splits]
    for suite in suites():
        own = [range(seed, seed + 1) for seed in suite.get("seeds", ())]
        if "split" in suite:
            first = suite["split"]["seed_first"]
            own.append(range(first, first + suite["split"]["seed_count"]))
        assert own
        assert all(max(a.start, b.start) >= min(a.stop, b.stop) for a in own for b in ranges)


def suites() -> list[dict[str, Any]]:
    """Return the shipped suites of drives, of recordings and of pictures, as they are written."""
    return [tomllib.loads(path.read_text()) for path in sorted((splits_folder() / "suites").glob("*.toml"))]


@pytest.mark.parametrize("kind", ["floors", "walls", "light_sets", "artworks"])
def test_looks_do_not_meet(kind: str) -> None:
    for a, b in combinations(NAMES, 2):
        first, second = getattr(load_split(a).looks, kind), getattr(load_split(b).looks, kind)
        assert first and second and not set(first) & set(second)


def test_every_artwork_belongs_to_one_family_and_training_has_most() -> None:
    of = {name: load_split(name).looks.artworks for name in NAMES}
    assert sorted(name for names in of.values() for name in names) == sorted(ARTWORKS)
    assert len(of["train"]) >= 3 and len(of["val"]) >= 2 and len(of["test"]) >= 2


def test_suites_show_what_test_shows() -> None:
    looks = load_split("test").looks
    for suite in suites():
        shown = suite.get("split", suite)["looks"]
        for kind in ("floors", "walls", "light_sets", "artworks"):
            assert set(shown[kind]) <= set(getattr(looks, kind))


def test_training_and_validation_draw_their_layouts() -> None:
    published = set(known_records("splits/layouts")) - {"open"}
    for name in ("train", "val"):
        assert not published & set(load_split(name).layouts)
    assert published == set(load_split("test").layouts) & published
    of_suites = {"random_d3", "random_d4", "random_p2", "random_b2"}
    assert set(RANDOM_LAYOUTS) - of_suites <= set(load_split("test").layouts)


def drawn_layouts(split: Split) -> Iterator[bytes]:
    """Yield what is set up in each of the first 300 scenarios, its name aside; nothing where it is open road."""
    course = Course(spec=COURSE_SETS[split.course])
    for number in range(300):
        name = layout_name(split, number)
        if name in RANDOM_LAYOUTS:
            layout = draw_layout(name, course, stream(split.seed(number, SALT), "layout"))
            assert layout.tunnel or layout.boxes or layout.works
            yield msgspec.json.encode(msgspec.structs.replace(layout, name="", signs=False))


def test_no_two_drawn_layouts_are_equal_within_or_between_the_splits() -> None:
    layouts = [layout for name in (*NAMES, "hidden") for layout in drawn_layouts(load_split(name))]
    assert len(layouts) > 800 and len(set(layouts)) == len(layouts)


def test_drawn_signs_are_of_the_family_and_all_of_it_occurs() -> None:
    for name in NAMES:
        split = load_split(name)
        drawn = {draw_look(split.looks, stream(split.seed(k, None), "look")).artwork for k in range(60)}
        assert drawn == set(split.looks.artworks)


def test_the_hidden_split_is_like_test_but_for_its_seeds() -> None:
    hidden, test = load_split("hidden"), load_split("test")
    assert hidden.salted and not test.salted
    as_test = msgspec.structs.replace(hidden, name="test", salted=False, seed_first=test.seed_first)
    assert as_test == test


def test_negatives_are_like_test_but_for_seeds_and_places() -> None:
    negatives, test = load_split("negatives"), load_split("test")
    as_test = msgspec.structs.replace(
        negatives,
        name="test",
        seed_first=test.seed_first,
        frames=test.frames,
        crosswalk_share=test.crosswalk_share,
    )
    assert as_test == test and negatives.crosswalk_share < test.crosswalk_share


def test_a_salt_makes_the_hidden_scenarios() -> None:
    hidden = load_split("hidden")
    first, again, other = ([draw_scenario(hidden, k, RIG, salt) for k in range(6)] for salt in (SALT, SALT, OTHER_SALT))
    assert first == again
    for one, another in zip(first, other, strict=True):
        assert one.seed != another.seed and one.robot_truth != another.robot_truth and one.look != another.look
    assert len({scenario.seed for scenario in (*first, *other)}) == 12
    open_seeds = {split.seed_first + k for split in map(load_split, NAMES) for k in range(split.seed_count)}
    assert not open_seeds & {scenario.seed for scenario in first}


def test_a_salt_makes_nothing_else_different() -> None:
    test = load_split("test")
    assert draw_scenario(test, 3, RIG, SALT) == draw_scenario(test, 3, RIG)


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
        ("frames = 1000", "frams = 640", "frams"),
        ("frames = 1000", 'frames = "many"', "$.frames"),
        ("frames = 1000", "frames = 0", "frames must lie in 1..3200000"),
        ("objects_share = 0.3", "objects_share = 0.6", "the sum of the last two must lie in 0..1"),
        ("random_works = 0.125", "random_works = 0.5", "the shares in layouts must be more than 0 and add up to 1"),
        ("signs_share = 0.8", 'course = "c"', "Invalid enum value 'c' - at `$.course`"),
        ("signs_share = 0.8", 'robot = "segway"', "Invalid enum value 'segway' - at `$.robot`"),
        ('"worn_vinyl"', '"lawn"', "looks.floors has the unknown name 'lawn'"),
        ('"enamel"', '"crayon"', "looks.artworks has the unknown name 'crayon'"),
        ('["tall", "enamel"]', "[]", "looks.artworks is empty"),
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
