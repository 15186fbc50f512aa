"""The map of what the laser met: places, forgetting, bounds, and cones told from boxes and chairs."""

import numpy as np
import pytest
from laser_hall import LASER, Hall, thing

from adc_bench.geometry import Pose2
from adc_bench.stack.laser_clusters import scan_points
from adc_bench.stack.obstacle_map import MapParams, ObstacleMap, Thing, cones_among, see, things

PARAMS = MapParams()
ORIGIN = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)


def mapped(hall: Hall, poses: list[Pose2]) -> tuple[Thing, ...]:
    """Return what a robot at these poses in turn has mapped."""
    known = ObstacleMap()
    for step, pose in enumerate(poses):
        known = see(known, scan_points(hall.scan(pose), LASER), pose, 0.1 * step, PARAMS)
    return things(known, np.ones(len(known.hits), dtype=bool), PARAMS)


def test_a_cone_is_found_where_it_stands_from_a_moving_robot() -> None:
    hall = Hall([thing(2.0, 0.5, 0.08, 0.08, shape="cylinder"), thing(2.0, -1.0, 0.6, 0.6)])
    found = mapped(hall, [Pose2(x_m=0.05 * k, y_m=0.0, yaw_rad=0.01 * k) for k in range(20)])
    (cone,) = cones_among(found, PARAMS)
    np.testing.assert_allclose(cone.middle_m, (1.96, 0.5), atol=0.04)
    assert max(one.width_m for one in found) > 0.5


def test_cones_of_a_row_are_told_apart_where_they_stand_near_to_each_other() -> None:
    row = [thing(x_m, 0.6, 0.08, 0.08, shape="cylinder") for x_m in (1.0, 1.6, 2.2)]
    found = mapped(Hall(row), [Pose2(x_m=0.05 * k, y_m=0.0, yaw_rad=0.01 * k) for k in range(20)])
    assert len(cones_among(found, PARAMS)) == 3


def test_a_chair_s_legs_are_no_cones() -> None:
    legs = [thing(1.5 + x, y, 0.04, 0.04, shape="cylinder") for x in (0.0, 0.4) for y in (-0.2, 0.2)]
    assert cones_among(mapped(Hall(legs), [ORIGIN] * 10), PARAMS) == ()


def test_what_was_met_once_is_forgotten_and_what_was_met_often_is_not() -> None:
    known = see(ObstacleMap(), np.array([[1.0, 0.0]]), ORIGIN, 0.0, PARAMS)
    for step in range(PARAMS.hits_kept + 1):
        known = see(known, np.array([[2.0, 0.0]]), ORIGIN, 0.1 * step, PARAMS)
    assert len(known.hits) == 2
    known = see(known, np.array([[3.0, 0.0]]), ORIGIN, PARAMS.forget_s + 1.0, PARAMS)
    assert known.points_world[:, 0] == pytest.approx([2.025, 3.025])


def test_the_map_is_bounded_and_keeps_the_newest() -> None:
    params, known = MapParams(cells_max=10), ObstacleMap()
    for step in range(30):
        known = see(known, np.array([[0.2 * step, 0.0]]), ORIGIN, 0.01 * step, params)
    assert len(known.hits) == 10
    assert known.points_world[:, 0].min() > 0.2 * 19


def test_no_scan_leaves_no_things() -> None:
    assert things(ObstacleMap(), np.zeros(0, dtype=bool), PARAMS) == ()
