import dataclasses

import numpy as np
import pytest
from floor_pictures import look

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.lane_lines import LaneLines, find_lane_lines
from adc_bench.stack.paint import find_paint
from adc_bench.world.course import Course

COURSE = Course()
HALF_LANE_M = 0.3875


def lines_at(birds_eye: BirdsEye, pose: Pose2, before: LaneLines | None = None, **light: float) -> LaneLines:
    paint = find_paint(birds_eye, look(pose, mount=birds_eye.mount, **light))
    return find_lane_lines(before or LaneLines(), paint, HALF_LANE_M)


def distances(points_robot: np.ndarray, pose: Pose2, s_m: float) -> np.ndarray:
    _, offset = COURSE.lap.project(pose.transform(points_robot), around_s_m=s_m + 1.2, window_m=2.0)
    return np.abs(offset) - HALF_LANE_M


@pytest.mark.parametrize("s_m", [1.5, 3.0, 7.0, 12.0, 25.0])
@pytest.mark.parametrize("aside", [(0.0, 0.0), (0.06, -0.1), (-0.06, 0.1)])
def test_a_hough_start_finds_both_lines(birds_eye: BirdsEye, s_m: float, aside: tuple[float, float]) -> None:
    pose = COURSE.lap.pose(s_m) @ Pose2(x_m=0.0, y_m=aside[0], yaw_rad=aside[1])
    lines = lines_at(birds_eye, pose)
    assert lines.right is not None and lines.left is not None
    for line in (lines.right, lines.left):
        assert len(line.points_robot) >= 4
        assert np.median(np.abs(distances(line.points_robot, pose, s_m))) < 0.01
    assert lines.right.points_robot[0, 1] < lines.left.points_robot[0, 1]


def test_lines_are_followed_from_picture_to_picture_round_a_bend(birds_eye: BirdsEye) -> None:
    lines = LaneLines()
    for s_m in np.arange(4.0, 16.0, 0.4):
        pose = COURSE.lap.pose(float(s_m))
        lines = lines_at(birds_eye, pose, lines)
        assert lines.right is not None
        assert np.abs(distances(lines.right.points_robot, pose, float(s_m))).max() < 0.05


def test_points_run_away_from_the_robot(birds_eye: BirdsEye) -> None:
    right = lines_at(birds_eye, COURSE.lap.pose(8.0)).right
    assert right is not None
    assert (np.diff(right.points_robot[:, 0]) > 0).all()


@pytest.mark.parametrize("s_m", [-2.0, -1.6, -1.2, -0.8, 19.6, 20.0])
def test_the_crosswalks_bars_are_no_lines(birds_eye: BirdsEye, s_m: float) -> None:
    pose = COURSE.lap.pose(s_m)
    lines = lines_at(birds_eye, pose)
    for line in (lines.right, lines.left):
        if line is not None:
            x, y = pose.transform(line.points_robot).T
            assert not ((np.abs(x) < 0.33) & (np.abs(y + 2.225) < 0.65)).any()


def test_bare_floor_has_no_lines(birds_eye: BirdsEye) -> None:
    lines = lines_at(birds_eye, COURSE.lap.pose(3.0), floor_level=60.0, paint_level=60.0)
    assert lines.right is None and lines.left is None


def test_a_lost_line_is_started_again(birds_eye: BirdsEye) -> None:
    pose = COURSE.lap.pose(8.0)
    right = lines_at(birds_eye, pose).right
    assert right is not None
    elsewhere = dataclasses.replace(right, points_robot=right.points_robot + np.array([0.0, 0.25]))
    again = lines_at(birds_eye, pose, LaneLines(right=elsewhere)).right
    assert again is not None
    np.testing.assert_allclose(again.points_robot[:5], right.points_robot[:5], atol=0.05)
