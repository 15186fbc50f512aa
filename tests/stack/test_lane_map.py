import math

import numpy as np
import pytest

from adc_bench.geometry import Pose2
from adc_bench.stack.ekf import Belief
from adc_bench.stack.lane_lines import LaneLine, LaneLines
from adc_bench.stack.lane_map import LaneMap
from adc_bench.world.course import Course

MAP = LaneMap(course=Course(), lap=Course().lap)
HALF_M = MAP.half_lane_m


def belief_at(pose: Pose2, sd: float = 0.0) -> Belief:
    return Belief(mean=np.array([pose.x_m, pose.y_m, pose.yaw_rad]), covariance=np.eye(3) * sd**2)


def seen_line(left_m: float, s_from: float, s_to: float, pose: Pose2) -> LaneLine:
    s = np.arange(s_from, s_to, 0.1)
    points = MAP.lap.poses(s)
    normals = np.column_stack([-np.sin(points[:, 2]), np.cos(points[:, 2])])
    return LaneLine(points_robot=pose.inverse().transform(points[:, :2] + left_m * normals), direction_rad=0.0)


def test_the_landmarks_are_those_of_the_course() -> None:
    circles = {(5.35, 0.0), (-5.35, 0.0), (0.9, 0.0), (-0.9, 0.0)}  # loops and S-roads
    pieces = [piece for piece in MAP.lap.pieces if piece.curvature_pm]
    found = {tuple(np.round(centre, 9) + 0.0) for piece in pieces for centre in MAP.centres(piece.curvature_pm)}
    assert found == circles
    lines = {(round(math.sin(line.normal_rad)), round(line.distance_m, 9)) for line in MAP.straights()}
    assert lines == {(1, -2.6125), (-1, 1.8375)}


def test_the_lines_radii_are_those_painted() -> None:
    pose = MAP.lap.pose(8.0)
    lines = LaneLines(right=seen_line(-HALF_M, 8.6, 10.0, pose), left=seen_line(HALF_M, 8.6, 10.0, pose))
    (stretch,) = MAP.stretches(lines, belief_at(pose), 8.0)
    assert sorted(stretch.by_radius()) == pytest.approx([2.225, 3.0])


def test_points_are_sorted_by_straight_and_bend_the_nearer_first() -> None:
    pose = MAP.lap.pose(4.3)
    lines = LaneLines(right=seen_line(-HALF_M, 4.9, 6.3, pose))
    straight, bend = MAP.stretches(lines, belief_at(pose), 4.3)
    assert straight.curvature_pm == 0
    assert bend.curvature_pm == pytest.approx(1 / 2.6125)
    counted = len(straight.points_robot[-HALF_M]) + len(bend.points_robot[-HALF_M])
    assert 12 <= counted <= 14  # the knot's margin is left out


def test_a_line_that_leaves_the_lap_is_left_out() -> None:
    pose = MAP.lap.pose(20.0)
    wrong = seen_line(-0.75, 20.6, 22.0, pose)
    assert MAP.stretches(LaneLines(right=wrong), belief_at(pose), 20.0) == ()


def test_an_unsure_belief_looks_wider() -> None:
    pose = MAP.lap.pose(2.0)
    line = seen_line(-HALF_M - 0.22, 2.6, 4.0, pose)
    assert MAP.stretches(LaneLines(right=line), belief_at(pose), 2.0) == ()
    assert len(MAP.stretches(LaneLines(right=line), belief_at(pose, sd=0.08), 2.0)) == 1
