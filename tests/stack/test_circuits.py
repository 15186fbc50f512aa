import math

import numpy as np
import pytest

from adc_bench.geometry import Pose2
from adc_bench.stack.circuits import WAYS, Circuits, Place, Ways
from adc_bench.world.course import Course
from adc_bench.world.route import route

COURSE = Course()
CIRCUITS = Circuits(course=COURSE)
START = Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)


@pytest.mark.parametrize("ways", WAYS)
def test_each_closes_and_comes_back_to_the_crosswalk(ways: Ways) -> None:
    circuit = CIRCUITS.by_ways[ways]
    end = circuit.path.pose(circuit.path.length_m - 1e-9)
    assert (end.x_m, end.y_m) == pytest.approx((0.0, -2.6125), abs=1e-6) and math.cos(end.yaw_rad) == pytest.approx(1)
    back = circuit.path.pose(circuit.crosswalk_back_m)
    assert (back.x_m, back.y_m) == pytest.approx((0.0, -1.8375)) and math.cos(back.yaw_rad) == pytest.approx(-1)


def test_straight_on_twice_is_the_lap() -> None:
    lap = CIRCUITS.by_ways["straight", "straight"]
    assert lap.path == COURSE.lap
    assert lap.crosswalk_back_m == pytest.approx(COURSE.crosswalk_back_m)


@pytest.mark.parametrize("ways", WAYS)
def test_a_robot_is_followed_over_every_pair_of_ways(ways: Ways) -> None:
    """It knows none of the orders; 3 cm and a degree beside the lane do not deceive it."""
    driven = route(COURSE, "east", (*ways, *ways[::-1]))
    place, noise = CIRCUITS.start(START), np.random.default_rng(0)
    for s_m in np.arange(0.0, driven.length_m - 1.0, 0.05):
        pose = driven.pose(float(s_m)) @ Pose2(x_m=0.0, y_m=0.03 * noise.standard_normal(), yaw_rad=math.radians(1))
        place = CIRCUITS.follow(place, pose)
        there = CIRCUITS.by_ways[place.ways].path.pose(place.s_m)
        assert math.hypot(there.x_m - pose.x_m, there.y_m - pose.y_m) < 0.2
        assert math.cos(there.yaw_rad - pose.yaw_rad) > math.cos(0.4)


def test_it_is_found_on_its_way_within_a_metre_of_the_parting() -> None:
    turn = CIRCUITS.by_ways["turn", "straight"]
    place = CIRCUITS.start(START)
    parting_m = COURSE.spec.s_road_centre_x_m
    for s_m in np.arange(0.0, parting_m + 1.0, 0.05):
        place = CIRCUITS.follow(place, turn.path.pose(float(s_m)))
    assert place.ways[0] == "turn"
    assert place.s_m == pytest.approx(parting_m + 0.95, abs=0.1)


def test_moving_over_round_a_box_stays_on_the_circuit() -> None:
    place = Place(ways=WAYS[0], s_m=2.0)
    for x_m in np.arange(2.0, 5.0, 0.05):
        left_m = 0.775 * math.sin(math.pi * (x_m - 2.0) / 3.0) ** 2
        place = CIRCUITS.follow(place, Pose2(x_m=float(x_m), y_m=-2.6125 + left_m, yaw_rad=0.0))
        assert place.ways == WAYS[0]
    assert place.s_m == pytest.approx(4.95, abs=0.05)
