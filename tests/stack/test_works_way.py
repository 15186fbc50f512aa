"""The corridor from cones: rows told apart on drawn road-works, whole or in part, and what is no cone of theirs."""

import numpy as np
import pytest
import shapely

from adc_bench.stack.works_way import WorksParams, corridor, works_cones
from adc_bench.world.course import Course
from adc_bench.world.drawing import draw_works
from adc_bench.world.layout import Works
from adc_bench.world.streams import stream

COURSE, PARAMS = Course(), WorksParams()
BEFORE = (1.0, 0.0)  # a robot on its way to the cones
S = np.arange(4.0, 20.0, 0.05)


def drawn(seed: int) -> Works:
    """Return road-works round the +x loop."""
    return draw_works(COURSE, stream(seed, "test", "works"), loops=("east",))


def seen(works: Works) -> tuple[np.ndarray, np.ndarray]:
    """Return where all the cones stand, seen from the lap, by arc length."""
    s, offset = COURSE.lap.project([*works.left, *works.right], around_s_m=11.0, window_m=10.0)
    order = np.argsort(s)
    return s[order], offset[order]


def way(s: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Return the corridor's middle (n, 2) in the world."""
    found = corridor(s, offset, COURSE.lap.curvature_pm(s), BEFORE, PARAMS)
    assert found is not None
    poses, aside = COURSE.lap.poses(S), found.offsets(S)
    normals = np.column_stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2])])
    return np.asarray(poses[:, :2] + aside[:, None] * normals)


@pytest.mark.parametrize("seed", range(30))
def test_the_way_leads_between_the_rows_with_room_on_both_sides(seed: int) -> None:
    works = drawn(seed)
    middle = shapely.LineString(way(*seen(works)))
    for row in (works.left, works.right):
        assert middle.distance(shapely.LineString(row)) > 0.28
    for end in (0, -1):
        assert middle.intersects(shapely.LineString([works.left[end], works.right[end]]))


def test_before_and_behind_the_cones_it_is_the_lane() -> None:
    s, offset = seen(drawn(1))
    found = corridor(s, offset, COURSE.lap.curvature_pm(s), BEFORE, PARAMS)
    assert found is not None
    assert np.abs(found.offsets(np.array([s[0] - 4.0, s[-1] + 4.0]))).max() < 0.01


@pytest.mark.parametrize("seed", range(10))
def test_the_near_part_of_the_way_is_known_from_the_cones_within_reach(seed: int) -> None:
    s, offset = seen(drawn(seed))
    whole = corridor(s, offset, COURSE.lap.curvature_pm(s), BEFORE, PARAMS)
    for reach_m in (3.0, 4.5):
        near = s < s[0] + reach_m
        part = corridor(s[near], offset[near], COURSE.lap.curvature_pm(s[near]), BEFORE, PARAMS)
        assert whole is not None and part is not None
        early = np.linspace(s[0] - 1.0, s[0] + reach_m - 1.8, 20)
        assert np.abs(part.offsets(early) - whole.offsets(early)).max() < 0.25


@pytest.mark.parametrize("here_m", [-0.5, 0.5])
def test_a_cone_is_on_that_side_of_the_corridor_on_which_the_robot_passes_it(here_m: float) -> None:
    s, offset = np.array([5.0]), np.array([0.0])
    found = corridor(s, offset, np.zeros(1), (4.6, here_m), PARAMS)
    assert found is not None
    beside, here = found.offsets(np.array([5.0, 4.6]))
    assert np.sign(beside) == np.sign(here_m) and abs(here - here_m) < PARAMS.here_m


def test_the_slope_is_the_offset_s_derivative() -> None:
    s, offset = seen(drawn(2))
    found = corridor(s, offset, COURSE.lap.curvature_pm(s), BEFORE, PARAMS)
    assert found is not None
    np.testing.assert_allclose(found.slopes(S), np.gradient(found.offsets(S), S), atol=5e-3)


def test_what_stands_far_from_the_lane_and_the_cones_is_no_cone_of_theirs() -> None:
    s, offset = np.array([1.0, 5.0, 6.2, 12.0]), np.array([-1.6, -0.5, -0.7, -1.2])
    np.testing.assert_array_equal(works_cones(s, offset, PARAMS), [1, 2])
    assert len(works_cones(s[[0, 3]], offset[[0, 3]], PARAMS)) == 0
    assert len(works_cones(np.zeros(0), np.zeros(0), PARAMS)) == 0


def test_what_stands_far_out_before_the_first_cone_in_the_lane_is_no_cone_of_theirs() -> None:
    """A chair's leg, the first that the laser meets of it."""
    s, offset = np.array([28.75, 29.76, 30.58, 30.93]), np.array([-1.73, -0.51, -0.85, 0.07])
    np.testing.assert_array_equal(works_cones(s, offset, PARAMS), [1, 2, 3])


def test_two_things_farther_apart_than_the_rows_are_no_gate() -> None:
    """A chair's leg beside the road, and the first cone."""
    s, offset = np.array([29.11, 29.50]), np.array([-1.95, -0.49])
    np.testing.assert_array_equal(works_cones(s, offset, PARAMS), [1])


@pytest.mark.parametrize("cone", [0, 1])
def test_what_stands_beside_the_first_cones_does_not_lead_off_the_way(cone: int) -> None:
    for seed in range(20):
        s, offset = (values[: cone + 1] for values in seen(drawn(seed)))
        here = (s[0] - 1.8, 0.0)
        alone = corridor(s, offset, COURSE.lap.curvature_pm(s), here, PARAMS)
        side = 1.0 if offset[0] > 0 else -1.0
        s, offset = np.append(s, s[-1] + 0.1), np.append(offset, offset[-1] + side * 1.6)
        joined = corridor(s, offset, COURSE.lap.curvature_pm(s), here, PARAMS)
        assert alone is not None and joined is not None
        early = np.linspace(s[0] - 1.5, s[0], 20)
        np.testing.assert_allclose(joined.offsets(early), alone.offsets(early), atol=0.05)


def test_without_cones_there_is_no_corridor() -> None:
    assert corridor(np.zeros(0), np.zeros(0), np.zeros(0), BEFORE, PARAMS) is None
