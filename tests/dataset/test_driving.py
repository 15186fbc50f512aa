"""Plans of drives: routes, legs, errors, missions; nothing is simulated."""

import math
from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np
import pytest

from adc_bench.dataset import Split, load_split
from adc_bench.dataset.drive_recipe import BEHAVIOURS, MISSIONS, SUITING, Behaviour, MissionName
from adc_bench.dataset.driving.floor import outlines, passes_m
from adc_bench.dataset.driving.hand import draw_hand, draw_wander
from adc_bench.dataset.driving.leg import STEP_M, course_aside, driven_line, speeds_mps, stations_m
from adc_bench.dataset.driving.plan import behaviour_of, draw_drive, mission_of
from adc_bench.errors import InputError
from adc_bench.geometry import Path as Curve
from adc_bench.geometry import Pose2, arc, line, wrap_rad
from adc_bench.world.course import COURSE_SETS, Course
from adc_bench.world.robot import ROBOTS
from adc_bench.world.route import crosswalk_pose, route
from adc_bench.world.sensors import SensorRig

TRAIN, COURSE, RIG = load_split("train"), Course(), SensorRig()


def only(mission: MissionName, behaviour: Behaviour, split: Split = TRAIN) -> Split:
    recipe = msgspec.structs.replace(split.drives, missions={mission: 1.0}, behaviours={behaviour: 1.0})
    return msgspec.structs.replace(split, drives=recipe)


@pytest.mark.parametrize("course", [Course(spec=spec) for spec in COURSE_SETS.values()], ids=list(COURSE_SETS))
def test_every_half_lap_leads_from_crosswalk_to_crosswalk(course: Course) -> None:
    for first, other in (("east", "west"), ("west", "east")):
        for way in ("straight", "turn"):
            path = route(course, first, [way])
            end, wanted = path.pose(path.length_m), crosswalk_pose(course, other)
            assert math.hypot(end.x_m - wanted.x_m, end.y_m - wanted.y_m) < 1e-9
            assert abs(wrap_rad(end.yaw_rad - wanted.yaw_rad)) < 1e-9


def test_straight_half_laps_are_the_lap_and_turned_ones_the_other_lane_against_it() -> None:
    s_m = np.linspace(0.0, 38.0, 200)
    np.testing.assert_allclose(route(COURSE, "east", ["straight"] * 2).poses(s_m)[:, :2], COURSE.lap.poses(s_m)[:, :2])
    turned = route(COURSE, "east", ["turn"] * 2).poses(s_m)
    _, aside = COURSE.lanes["left"].project(turned[:, :2])
    np.testing.assert_allclose(aside, 0.0, atol=1e-9)
    assert turned[0, 2] == 0.0 and turned[10, 2] > 0.1  # left at the crosswalk, up the S-road


def test_a_driven_line_beside_an_arc_is_an_arc() -> None:
    path = Curve(start=Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), pieces=(arc(2.0, 2.0),))
    found = driven_line(path, np.full(len(stations_m(path)), 0.5))
    centre = found[:, :2] - (0.0, 2.0)
    np.testing.assert_allclose(np.hypot(*centre.T), 1.5, rtol=1e-9)
    np.testing.assert_allclose(found[2:-2, 3], 1 / 1.5, rtol=1e-3)


def test_a_driven_lines_heading_and_curvature_are_those_of_its_points() -> None:
    path = COURSE.lap
    found = driven_line(path, course_aside(path, [(3.0, 0.0), (5.0, 0.775), (8.0, 0.775), (10.0, 0.0)]))
    steps = np.diff(found[:, :2], axis=0)
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    middle = (found[1:, 2] + found[:-1, 2]) / 2
    assert np.abs(np.angle(np.exp(1j * (heading - middle)))).max() < 0.01
    turned = np.trapezoid(found[:, 3], np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))]))
    assert turned == pytest.approx(found[-1, 2] - found[0, 2], abs=0.05)


def test_speeds_obey_bends_brakes_and_the_end() -> None:
    path = Curve(start=Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), pieces=(line(6.0), arc(0.5, math.pi), line(6.0)))
    found = driven_line(path, np.zeros(len(stations_m(path))))
    speed = speeds_mps(found, 0.0, 11.0, cruise_mps=1.5, lateral_mps2=1.0, braking_mps2=0.8)
    assert speed.max() == 1.5 and (speed**2 * np.abs(found[:, 3]) <= 1.0 + 1e-9).all()
    assert (np.abs(np.diff(speed**2)) <= 2 * 0.8 * STEP_M + 1e-9).all()
    assert speed[0] == 0 and (speed[np.arange(len(speed)) * STEP_M > 11.0] == 0).all()


def test_the_wandering_has_its_spread_and_a_clean_hand_none() -> None:
    rng = np.random.default_rng(5)
    spreads = [draw_wander("sloppy", 20_000, 1.0, rng).std() for _ in range(20)]
    assert min(spreads) > 0.01 and max(spreads) < 0.11
    assert not draw_wander("clean", 100, 1.0, rng).any()
    hand = draw_hand("clean", 100, 1.0, rng)
    assert hand.delay_steps == 1 and not hand.steering_radps.any()
    knocked = draw_hand("recovery", 600, 1.0, rng).steering_radps
    assert np.abs(knocked).max() > 0.9


def test_a_point_is_passed_where_a_dense_search_finds_it() -> None:
    path = route(COURSE, "east", ["straight"] * 3)
    found = passes_m(path, stations_m(path), 5.35, -2.3, 0.6)
    np.testing.assert_allclose([s_m for s_m, _ in found], (5.35, COURSE.lap.length_m + 5.35), atol=STEP_M)
    assert all(aside == pytest.approx(0.3125, abs=0.01) for _, aside in found)


def test_outlines_are_the_robot_turned_and_moved() -> None:
    polygon = outlines(np.array([[1.0, 2.0, math.pi / 2]]), ROBOTS["pioneer"])[0]
    assert polygon.bounds == pytest.approx((1 - 0.19, 2 - 0.23, 1 + 0.19, 2 + 0.23))


def test_shares_of_missions_hold_in_every_stretch() -> None:
    for first in (0, 1000):
        names = [mission_of(TRAIN.drives, number) for number in range(first, first + 200)]
        for mission, share in TRAIN.drives.missions.items():
            assert abs(names.count(mission) / 200 - share) < 0.02
    assert {mission_of(TRAIN.drives, number) for number in range(40)} == set(MISSIONS)
    drawn = [behaviour_of(TRAIN.drives, "speed", n) for n in range(600) if mission_of(TRAIN.drives, n) == "speed"]
    free = {name: TRAIN.drives.behaviours[name] for name in SUITING["speed"]}
    for behaviour, share in free.items():
        assert abs(drawn.count(behaviour) / len(drawn) - share / sum(free.values())) < 0.04


def test_a_drive_is_the_same_whenever_it_is_drawn_and_another_for_another_seed() -> None:
    first, again, other = (draw_drive(TRAIN, number, RIG) for number in (5, 5, 6))
    assert first[0] == again[0] and first[1].script == again[1].script
    np.testing.assert_array_equal(first[1].hand.steering_radps, again[1].hand.steering_radps)
    for a, b in zip(first[1].legs, again[1].legs, strict=True):
        np.testing.assert_array_equal(a.line, b.line)
    assert first[0].seed == TRAIN.seed_first + TRAIN.seed_count - 6 and other[0].seed == first[0].seed - 1


@pytest.mark.parametrize("mission", MISSIONS)
def test_every_mission_is_planned_in_all_its_ways(mission: MissionName) -> None:
    for behaviour in SUITING[mission]:
        split = only(mission, behaviour)
        for number in range(3):
            _, plan = draw_drive(split, number, RIG)
            assert (plan.script.mission, plan.script.behaviour) == (mission, behaviour)
            assert plan.script.delay_steps == 1 or behaviour != "clean"
            for before, leg in pairwise(plan.legs):
                gap = np.hypot(*(leg.poses[0, :2] - before.poses[-1, :2]))
                assert gap < (0.03 if behaviour == "clean" else 0.4)


def test_both_ways_round_are_driven() -> None:
    turns = []
    for number in range(12):
        _, plan = draw_drive(only("speed", "clean"), number, RIG)
        poses = plan.legs[0].poses
        in_east_loop = np.hypot(poses[:, 0] - 5.35, poses[:, 1]) < 3.0
        turns += np.sign(plan.legs[0].line[: len(poses), 3][in_east_loop[: len(poses)]]).tolist()
    assert turns.count(1.0) > 100 and turns.count(-1.0) > 100


def test_parking_with_and_without_boxes_forwards_and_backwards() -> None:
    for mission in ("parallel_parking", "bay_parking"):
        plans = [draw_drive(only(mission, "clean"), number, RIG) for number in range(16)]
        assert {bool(scenario.layout.boxes) for scenario, _ in plans} == {True, False}
        ways = {plan.legs[-1].backwards for _, plan in plans}
        assert ways == ({True} if mission == "parallel_parking" else {True, False})


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("count = 0", "drives.count must be at least 1"),
        ("duration_s = [30.0, 20.0]", "drives.duration_s must be two times in 1..600, the shorter first"),
        ("missions = { speed = 0.5 }", "the shares in drives.missions must be more than 0 and add up to 1"),
        ("missions = { race = 1.0 }", "race"),
        (
            "missions = { works = 1.0 }\nbehaviours = { bump = 1.0 }",
            "no behaviour in drives.behaviours suits works",
        ),
    ],
)
def test_a_bad_recipe_says_what_is_wrong(tmp_path: Path, text: str, told: str) -> None:
    whole = (Path(__file__).parents[2] / "splits" / "val.toml").read_text()
    path = tmp_path / "bad.toml"
    path.write_text(whole[: whole.index("[drives]")] + "[drives]\n" + text + "\n")
    with pytest.raises(InputError) as caught:
        load_split(str(path))
    assert told in str(caught.value)


def test_every_behaviour_suits_some_mission() -> None:
    assert {name for names in SUITING.values() for name in names} == set(BEHAVIOURS)
