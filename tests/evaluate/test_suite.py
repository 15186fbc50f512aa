from pathlib import Path

import msgspec
import pytest

from adc_bench.dataset.split import load_split
from adc_bench.errors import InputError
from adc_bench.evaluate.programme import Trial
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.suite import (
    Suite,
    check_salt,
    load_suite,
    mission_for,
    rules_for,
    rules_id,
    scenario_for,
    start_step,
)
from adc_bench.world.course import COURSE_SETS
from adc_bench.world.records import find_record, known_records
from adc_bench.world.robot import ROBOTS
from adc_bench.world.salt import salt_sha256

D1 = load_suite("d1")
RANKED = ("d1", "d2", "d3", "d4", "p1", "p2", "b1", "b2", "v1")


@pytest.mark.parametrize("name", known_records("splits/suites"))
def test_shipped_suites_are_sound_and_unseen(name: str) -> None:
    suite, train = load_suite(name), load_split("train")
    assert suite.name == name
    looks = suite.looks if isinstance(suite, Suite) else suite.split.looks
    assert not set(looks.floors) & set(train.looks.floors)
    assert not set(looks.walls) & set(train.looks.walls)
    assert not set(looks.light_sets) & set(train.looks.light_sets)
    assert rules_id(suite) == rules_id(load_suite(name))


@pytest.mark.parametrize("name", RANKED)
def test_each_trial_of_a_ranked_suite_meets_the_light_levels_in_turn(name: str) -> None:
    suite = load_suite(name)
    met: dict[tuple[str, ...], set[str]] = {(*trial.orders, trial.layout): set() for trial in suite.trials}
    for seed in suite.seeds:
        scenario, trial = scenario_for(suite, seed), suite.trial(seed)
        met[(*trial.orders, trial.layout)].add(scenario.look.light_level)
    assert set().union(*met.values()) == {"dark", "dim", "normal", "bright"}
    assert all(len(levels) >= min(4, len(suite.seeds) // len(suite.trials)) for levels in met.values())


def test_a_seed_gives_one_scenario() -> None:
    first, second = D1.seeds[:2]
    assert scenario_for(D1, first) == scenario_for(D1, first)
    assert scenario_for(D1, first).robot_truth != scenario_for(D1, second).robot_truth
    assert scenario_for(D1, first).panel_sign == "stop"


def test_the_arrow_appears_within_the_range_at_different_times() -> None:
    steps = [start_step(D1, seed) for seed in D1.seeds]
    assert all(1.0 <= step * RULES.control_period_s <= 5.0 for step in steps)
    assert len(set(steps)) == len(steps)


def test_the_mission_is_the_same_for_every_seed_and_holds_no_truth() -> None:
    mission = msgspec.json.encode(mission_for(D1, latency_s=0.0, options={}))
    truth = scenario_for(D1, D1.seeds[0]).robot_truth
    for value in msgspec.structs.astuple(truth):
        assert repr(value).encode() not in mission
    assert b"seed" not in mission


def test_the_rules_digest_covers_rules_and_suite() -> None:
    digests = {
        rules_id(D1).sha256,
        rules_id(msgspec.structs.replace(D1, trials=(Trial(orders=("up", "up", "end")),))).sha256,
        rules_id(D1, msgspec.structs.replace(RULES, touch_gap_s=1.0)).sha256,
    }
    assert len(digests) == 3


def changed(tmp_path: Path, old: str, new: str) -> str:
    text = find_record("d1", "splits/suites").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return str(path)


def test_a_suite_of_ones_own_is_loaded_by_its_path(tmp_path: Path) -> None:
    assert load_suite(changed(tmp_path, "180.0", "90.0")) == msgspec.structs.replace(D1, time_limit_s=90.0)


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("180.0", '"long"', "Expected `float`, got `str` - at `$.time_limit_s`"),
        ("[[trials]]", "laps = 2\n[[trials]]", "Object contains unknown field `laps`"),
        (
            '"up", "up", "up", "up", "end"',
            '"up", "back", "end"',
            "Invalid enum value 'back' - at `$.trials[0].orders[1]`",
        ),
        ('"up", "up", "up", "up", "end"', '"up", "end"', "orders = ['up', 'end']"),
        ('"up", "up", "up", "up", "end"', '"left", "up", "end"', "orders = ['left', 'up', 'end']"),
        ('"up", "up", "up", "up", "end"', '"up", "up", "park"', "orders = ['up', 'up', 'park']"),
        ("[looks]", '[[trials]]\norders = ["up", "up", "end"]\n[looks]', "trials of different lengths, or none"),
        ("[looks]", 'layout = "d3_v1"\n[looks]', "elements = [], and boxes in the layout 'd3_v1'"),
        ("180.0", "180.0\nstart_x_m = 1.0", "start_x_m = 1.0"),
        ('"felt"', '"velvet"', "looks.floors = ['velvet', 'painted_board', 'scuffed_linoleum']"),
        ("[1.0, 5.0]", "[5.0, 1.0]", "start_delay_s = [5.0, 1.0]"),
        ("7001, 7002", "7001, 7001", "a seed twice"),
        ("180.0", "-1.0", "time_limit_s = -1.0"),
        ("180.0", "180.0\nsemantic_camera = true", "semantic_camera = true in a ranked suite"),
        ("180.0", '180.0\ncourse = "c"', "Invalid enum value 'c' - at `$.course`"),
        ("180.0", '180.0\nrobot = "segway"', "Invalid enum value 'segway' - at `$.robot`"),
    ],
)
def test_what_is_wrong_with_a_suite_is_told(tmp_path: Path, old: str, new: str, found: str) -> None:
    with pytest.raises(InputError) as caught:
        load_suite(changed(tmp_path, old, new))
    assert caught.value.found == found
    assert caught.value.where.endswith("mine.toml")


def test_an_unknown_layout_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        load_suite(changed(tmp_path, "[looks]", 'layout = "d9"\n[looks]'))
    assert caught.value.where == "layout 'd9'" and "d3_v1" in caught.value.wanted


def test_a_box_at_the_start_is_refused_by_name(tmp_path: Path) -> None:
    layout = tmp_path / "layout.toml"
    layout.write_text('name = "mine"\n[[boxes]]\nx_m = -0.5\ny_m = -2.6\n')
    with pytest.raises(InputError) as caught:
        load_suite(changed(tmp_path, "[looks]", f'layout = "{layout}"\n[looks]'))
    assert caught.value.found == "overlapping: the robot at its start and box_0"


def test_a_suite_names_its_layout_robot_course_and_semantic_camera() -> None:
    trials = (Trial(orders=D1.trials[0].orders, layout="d3_v2"),)
    fields = {"trials": trials, "robot": "conde", "course": "b", "semantic_camera": True, "ranked": False}
    suite = msgspec.structs.replace(D1, **fields)
    rules, scenario = rules_for(suite), scenario_for(suite, D1.seeds[0])
    mission = mission_for(suite, latency_s=0.0, options={})
    assert len(scenario.layout.boxes) == 2 and scenario.rig.semantic
    for holder in (rules, mission, scenario):
        assert holder.robot == ROBOTS["conde"]
    assert rules.course == mission.course == scenario.course_spec == COURSE_SETS["b"]
    assert mission.start_pose.y_m == pytest.approx(-2.75)
    assert rules_for(D1) == RULES and scenario_for(D1, D1.seeds[0]).furniture
    ids = {rules_id(msgspec.structs.replace(D1, **{key: value})).sha256 for key, value in fields.items()}
    assert len(ids) == 5 and rules_id(D1).sha256 not in ids


def test_what_a_layout_file_holds_is_in_the_digest(tmp_path: Path) -> None:
    digests = set()
    for x_m in (2.0, 2.5):
        layout = tmp_path / "layout.toml"
        layout.write_text(f'name = "mine"\n[[boxes]]\nx_m = {x_m}\ny_m = -2.6\n')
        digests.add(
            rules_id(
                msgspec.structs.replace(D1, trials=(Trial(orders=("up", "up", "end"), layout=str(layout)),))
            ).sha256
        )
    assert len(digests) == 2


def test_a_hidden_suite_is_drawn_with_its_salt_alone(tmp_path: Path) -> None:
    salt, other = b"0123456789abcdef", b"fedcba9876543210"
    text = f'180.0\nsalt_sha256 = "{salt_sha256(salt)}"'
    hidden, seed = load_suite(changed(tmp_path, "180.0", text)), D1.seeds[0]
    drawn = [scenario_for(hidden, seed, salt=one) for one in (salt, other)] + [scenario_for(D1, seed)]
    assert len({scenario.robot_truth for scenario in drawn}) == 3
    assert {scenario.name for scenario in drawn} == {f"d1-{seed}"}, "its public name"
    assert scenario_for(hidden, seed, salt=salt) == drawn[0] and drawn[0].seed != seed
    steps = [start_step(hidden, seed, salt=salt) for seed in D1.seeds]
    assert steps != [start_step(D1, seed) for seed in D1.seeds]
    check_salt(D1, None)
    check_salt(hidden, salt)
    for wrong, found in ((None, "no salt"), (other, f"a salt with the digest {salt_sha256(other)}")):
        with pytest.raises(InputError) as caught:
            check_salt(hidden, wrong)
        assert caught.value.found == found and salt_sha256(salt) in caught.value.wanted
        assert "--salt-file" in caught.value.todo


def test_the_digest_of_a_hidden_suite_needs_no_salt() -> None:
    hidden = msgspec.structs.replace(load_suite("d4"), salt_sha256="0" * 64)
    assert rules_id(hidden) == rules_id(hidden) != rules_id(load_suite("d4"))


def test_a_suite_is_a_record() -> None:
    assert msgspec.json.decode(msgspec.json.encode(D1), type=Suite) == D1
