"""Clusters of scans of made things."""

import math

import numpy as np
import pytest
from laser_hall import LASER, Hall, thing

from adc_bench.api import LaserScan
from adc_bench.geometry import Pose2
from adc_bench.stack.laser_clusters import clusters, scan_points

ORIGIN = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)


def test_points_lie_where_the_beams_ended() -> None:
    ranges = np.full(LASER.beams, LASER.range_max_m)
    middle = LASER.beams // 2
    ranges[[middle, middle + 50]] = 1.0
    angle = (middle + 50) * LASER.step_rad - LASER.field_rad / 2
    expected = [(LASER.x_m + 1.0, 0.0), (LASER.x_m + math.cos(angle), math.sin(angle))]
    np.testing.assert_allclose(scan_points(LaserScan(time_s=0.0, ranges_m=ranges), LASER), expected, atol=0.02)


def test_an_empty_hall_has_no_clusters() -> None:
    assert clusters(Hall([thing(50.0, 0.0, 1.0, 1.0)]).scan(ORIGIN), LASER) == ()


@pytest.mark.parametrize("distance_m", [0.8, 1.5])
def test_a_box_and_a_cone_are_told_apart_by_their_widths(distance_m: float) -> None:
    box, cone = thing(distance_m + 0.3, -0.6, 0.6, 0.6), thing(distance_m, 0.6, 0.08, 0.08, shape="cylinder")
    right, left = clusters(Hall([box, cone]).scan(ORIGIN), LASER)
    assert right.width_m > 0.55 and left.width_m < 0.15
    assert right.bearings_rad.mean() < 0 < left.bearings_rad.mean()


def test_every_return_is_in_one_cluster() -> None:
    hall = Hall([thing(2.0, y, 0.3, 0.3) for y in (-1.5, -0.5, 0.6, 1.4)])
    scan = hall.scan(ORIGIN)
    found = clusters(scan, LASER)
    assert len(found) == 4
    np.testing.assert_array_equal(np.concatenate([one.points_robot for one in found]), scan_points(scan, LASER))
