"""Where one may drive: the road, round road-works, and before the bay."""

import numpy as np
import pytest

from adc_bench.evaluate.ground import ground_of
from adc_bench.world.course import Course
from adc_bench.world.layout import Layout
from adc_bench.world.setup import draw_layout, load_layout
from adc_bench.world.streams import stream

COURSE = Course()
ROAD = ground_of(COURSE, Layout(), None)
POINTS = np.stack(np.meshgrid(np.arange(-10.0, 10.0, 0.13), np.arange(-6.0, 6.0, 0.11)), axis=-1).reshape(-1, 2)


def test_the_open_road_is_the_course() -> None:
    assert (ROAD.is_drivable(POINTS) == COURSE.on_road(POINTS)).all()
    assert ROAD.distance_to_lines_m(POINTS) == pytest.approx(COURSE.distance_to_edge_lines_m(POINTS))


@pytest.mark.parametrize("name", ["d4_v1", "d4_v2", "random_d4"])
def test_round_road_works_the_floor_outside_the_road_opens(name: str) -> None:
    layout = load_layout(name) if name != "random_d4" else draw_layout(name, COURSE, stream(3, "layout"))
    assert layout.works
    ground, cones = ground_of(COURSE, layout, None), np.array([*layout.works.left, *layout.works.right])
    assert ground.is_drivable(cones).all(), "and on the way between them"
    opened = ground.is_drivable(POINTS) & ~COURSE.on_road(POINTS)
    assert opened.any() and (ground.is_drivable(POINTS) >= COURSE.on_road(POINTS)).all()
    apart_m = np.linalg.norm(POINTS[opened][:, None] - cones[None], axis=2).min(axis=1)
    assert apart_m.max() < 2.0, "no more than that"
    loops = np.array([(5.35, 0.0), (-5.35, 0.0)])
    assert np.linalg.norm(POINTS[opened][:, None] - loops[None], axis=2).min() > 1.45, "the islands stay shut"
    inner = loops[0] + 1.45 * np.array([[1.0, 0.0], [0.0, 1.0]])
    assert ground.distance_to_lines_m(inner) == pytest.approx(0.0, abs=1e-3), "and their lines count"


def test_the_floor_before_the_bay_opens_for_those_who_park_there() -> None:
    before = np.array([(-2.2, -3.15), (-1.8, -3.8)])
    for parking, opens in ((None, False), ("parallel", False), ("bay", True)):
        ground = ground_of(COURSE, Layout(), parking)
        assert ground.is_drivable(before).tolist() == [opens, opens]
        line = [(-2.2, -3.0)]
        assert (ground.distance_to_lines_m(line)[0] > 0.4) == opens
    far_line_m = -COURSE.spec.radius_outer_m - 0.025 - 0.25 - 1.05 + 0.025
    assert ground_of(COURSE, Layout(), "bay").distance_to_lines_m([(-2.2, far_line_m)]) == pytest.approx(0.0, abs=1e-9)
