"""The published layouts against the published coordinates, brought here by a transform of the test's own."""

import math
from itertools import pairwise

import numpy as np
import pytest
import shapely

from adc_bench.world.course import COURSE_SETS, Course
from adc_bench.world.layout import Layout
from adc_bench.world.records import known_records
from adc_bench.world.setup import load_layout
from adc_bench.world.signs import INNER_PLACES, OUTER_PLACES, sign_places

COURSE = Course()
EAST_LOOP, WEST_LOOP, CROSSWALK = (0.403, 0.246), (0.403, -0.225), (0.403, 0.045)
CONDE_WORKS_OUTER = [(-0.94, 8.3), (-0.03, 8.87), (1.19, 8.7), (2.15, 7.92), (2.67, 6.68), (2.67, 5.41)]
CONDE_WORKS_INNER = [(1.16, 7.67), (1.56, 6.62), (1.79, 5.28)]
REFEREE_WORKS = [
    (-2.33, -7.58),
    (-3.14, -7.53),
    (-3.83, -6.8),
    (-3.99, -5.58),
    (-2.99, -6.24),
    (-3.69, -4.63),
    (-2.82, -5.29),
    (-3.33, -3.89),
    (-2.46, -4.21),
]


def to_world(points: list[tuple[float, float]], shift: tuple[float, float]) -> set[tuple[float, float]]:
    """From CONDE's frame: shifted onto the course, then x_world = y, y_world = -x."""
    return {(round(y + shift[1], 3), round(-x - shift[0], 3)) for x, y in points}


def boxes(name: str) -> set[tuple[float, float]]:
    return {(box.x_m, box.y_m) for box in load_layout(name).boxes}


def test_the_published_layouts_are_there() -> None:
    names = ["b2_v1", "b2_v2", "d3_v1", "d3_v2", "d4_v1", "d4_v2", "open", "p2", "v1"]
    assert known_records("splits/layouts") == names
    assert [load_layout(name).name for name in names] == names
    assert load_layout("open") == Layout()
    assert [name for name in names if load_layout(name).signs] == ["v1"]


def test_boxes_stand_where_they_were_published() -> None:
    assert boxes("d3_v1") == to_world([(-2.2, -5), (2.1, -5)], WEST_LOOP)
    assert boxes("d3_v2") == to_world([(-3, -5), (1.4, -5)], WEST_LOOP)
    assert boxes("p2") == to_world([(2.99, 2.30), (2.99, 3.75)], EAST_LOOP)
    assert boxes("b2_v1") == to_world([(3.38, -1.90)], CROSSWALK)
    assert boxes("b2_v2") == to_world([(3.38, -2.66)], CROSSWALK)


@pytest.mark.parametrize(("name", "radii"), [("d3_v1", (1.80, 2.51)), ("d3_v2", (2.60, 1.81))])
def test_d3_boxes_stand_in_one_lane_each(name: str, radii: tuple[float, float]) -> None:
    found = [math.hypot(box.x_m + 5.35, box.y_m) for box in load_layout(name).boxes]
    assert found == pytest.approx(radii, abs=0.01)


def test_p2_leaves_a_gap_of_85_cm_inside_the_bay() -> None:
    first, second = load_layout("p2").boxes
    assert abs(first.x_m - second.x_m) - 0.6 == pytest.approx(0.85)
    bay = shapely.Polygon(COURSE.bulge_corners)
    for box in (first, second):
        assert bay.contains(shapely.box(box.x_m - 0.3, box.y_m - 0.3, box.x_m + 0.3, box.y_m + 0.3))


@pytest.mark.parametrize(("name", "taken"), [("b2_v1", "bay_near"), ("b2_v2", "bay_far")])
def test_b2_takes_one_place_and_leaves_the_other_free(name: str, taken: str) -> None:
    (box,) = load_layout(name).boxes
    floor = shapely.box(box.x_m - 0.3, box.y_m - 0.3, box.x_m + 0.3, box.y_m + 0.3)
    for place in COURSE.parking_places[1:]:
        half = np.array([place.length_m, place.width_m]) / 2
        ground = shapely.Polygon(place.pose.transform(half * [(1, 1), (-1, 1), (-1, -1), (1, -1)]))
        covered = ground.intersection(floor).area / floor.area
        assert covered > 0.95 if place.name == taken else covered == 0.0


def test_the_works_are_the_published_cones_in_two_rows() -> None:
    conde, referee = load_layout("d4_v1").works, load_layout("d4_v2").works
    assert conde and referee
    assert set(conde.right) == to_world(CONDE_WORKS_OUTER, EAST_LOOP)
    assert set(conde.left) == to_world(CONDE_WORKS_INNER, EAST_LOOP)
    assert {*referee.left, *referee.right} == to_world(REFEREE_WORKS, WEST_LOOP)
    assert len(referee.left) + len(referee.right) == 9


@pytest.mark.parametrize(("name", "loop_x", "sense"), [("d4_v1", 5.35, 1.0), ("d4_v2", -5.35, -1.0)])
def test_rows_run_in_driving_order_on_their_sides_with_published_spacing(
    name: str, loop_x: float, sense: float
) -> None:
    works = load_layout(name).works
    assert works
    for row in (works.left, works.right):
        angles = np.unwrap([math.atan2(y, x - loop_x) for x, y in row])
        assert np.all(np.diff(angles) * sense > 0)
        assert all(0.7 < math.dist(a, b) < 1.45 for a, b in pairwise(row))
    left, right = ([math.hypot(x - loop_x, y) for x, y in row] for row in (works.left, works.right))
    outer, inner = (right, left) if sense > 0 else (left, right)
    assert min(outer) > 3.05 and max(outer) > 3.75 and max(inner) < 3.02


def test_signs_stand_outside_the_lines_and_face_their_traffic() -> None:
    for places, sense in ((OUTER_PLACES, 1.0), (INNER_PLACES, -1.0)):
        for x, y, yaw in places:
            loop_x = math.copysign(5.35, x)
            radius = math.hypot(x - loop_x, y)
            assert 3.05 < radius < 3.25 if sense > 0 else radius < 1.40
            travel = sense * np.array([-y, x - loop_x]) / radius  # the way of the traffic beside the sign
            assert travel @ (math.cos(yaw), math.sin(yaw)) < -0.85
    feet = [place[:2] for place in (*OUTER_PLACES, *INNER_PLACES)]
    assert not COURSE.on_road(feet).any()
    assert COURSE.distance_to_edge_lines_m(feet).min() > 0.07  # the nearest is beside the tip of the parallel bay


def test_sign_places_are_the_published_ones() -> None:
    east = [(2.8, 5), (0, 8.3), (-3.6, 5), (0, 4), (-1.6, 5), (0, 6.3)]
    west = [(-3.6, -5), (0, -8.3), (2.8, -5), (0.6, -5), (0, -6.2), (-1.6, -5)]
    found = {(x, y) for x, y, _ in (*OUTER_PLACES, *INNER_PLACES)}
    assert found == to_world(east, EAST_LOOP) | to_world(west, WEST_LOOP)


def test_signs_keep_their_distance_from_the_lines_of_set_b() -> None:
    a, b = COURSE_SETS["a"], COURSE_SETS["b"]
    for first, second in zip(sign_places(a), sign_places(b), strict=True):
        gaps = []
        for spec, place in ((a, first), (b, second)):
            radius = math.hypot(place.x_m - math.copysign(spec.loop_centre_x_m, place.x_m), place.y_m)
            line = spec.radius_outer_m if radius > 2 else spec.radius_inner_m
            gaps.append(abs(radius - line) - spec.edge_line_width_m / 2)
        assert gaps[0] == pytest.approx(gaps[1])
