"""The driver without a map, and the arc by which it keeps to its lane."""

import math

import numpy as np
import pytest
from test_driver import LAP, World, drive, mission

from adc_bench.geometry import Pose2
from adc_bench.stack.lane_arc import LaneArc, LaneArcParams, abreast, correct
from adc_bench.stack.lane_follower import LaneFollower
from adc_bench.stack.lane_lines import LaneLine, LaneLines
from adc_bench.stack.path_following import progress

HALF_M = 0.3875
PARAMS = LaneArcParams()
HERE = Pose2(x_m=1.0, y_m=-2.0, yaw_rad=0.4)


def on_arc(curvature_pm: float, left_m: float, s_m: np.ndarray) -> np.ndarray:
    """Return points (n, 2) beside an arc that sets out along +x, integrated step by step."""
    fine_s = np.linspace(0.0, 1.0, 2001)[None, :] * s_m[:, None]
    yaw = curvature_pm * fine_s
    x, y = np.trapezoid(np.cos(yaw), fine_s, axis=1), np.trapezoid(np.sin(yaw), fine_s, axis=1)
    normal = np.stack([-np.sin(yaw[:, -1]), np.cos(yaw[:, -1])], axis=1)
    return np.stack([x, y], axis=1) + left_m * normal


def lines_of(curvature_pm: float, offset_m: float, yaw_rad: float, sides: str = "rl") -> LaneLines:
    """Return the lines of a lane whose middle passes a robot so far to its left and so turned."""
    lane = Pose2(x_m=0.0, y_m=offset_m, yaw_rad=yaw_rad)
    s_m = np.arange(0.5, 1.6, 0.1)
    right, left = (
        LaneLine(points_robot=lane.transform(on_arc(curvature_pm, side, s_m)), direction_rad=yaw_rad)
        for side in (-HALF_M, HALF_M)
    )
    return LaneLines(right=right if "r" in sides else None, left=left if "l" in sides else None)


@pytest.mark.parametrize("sides", ["rl", "r", "l"])
@pytest.mark.parametrize("curvature_pm", [0.0, 0.38, -0.54])
def test_the_arc_becomes_that_of_the_lines(curvature_pm: float, sides: str) -> None:
    arc = LaneArc(pose=HERE)
    lines = lines_of(curvature_pm, 0.04, -0.05, sides)
    for _ in range(150):
        arc = correct(arc, HERE, lines, HALF_M, PARAMS)
    seen = HERE.inverse() @ arc.pose
    # The arc begins beside the robot, the lane was laid through x = 0: the same but for the slant.
    assert seen.y_m == pytest.approx(0.04, abs=0.006)
    assert seen.yaw_rad == pytest.approx(-0.05, abs=0.01)
    assert arc.curvature_pm == pytest.approx(curvature_pm, abs=0.02)
    assert np.linalg.eigvalsh(arc.covariance).min() > 0


@pytest.mark.parametrize("curvature_pm", [0.0, 1e-9, 0.38, -0.54])
def test_abreast_is_the_arc_s_place_nearest_to_the_robot(curvature_pm: float) -> None:
    arc = LaneArc(pose=Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), curvature_pm=curvature_pm)
    aside = on_arc(curvature_pm, 0.1, np.array([1.3]))[0]
    there = abreast(arc, Pose2(x_m=float(aside[0]), y_m=float(aside[1]), yaw_rad=0.7)).pose
    np.testing.assert_allclose((there.x_m, there.y_m), on_arc(curvature_pm, 0.0, np.array([1.3]))[0], atol=1e-6)
    assert there.yaw_rad == pytest.approx(1.3 * curvature_pm, abs=1e-6)


def test_a_line_that_branches_off_does_not_lead_away() -> None:
    straight, branch = lines_of(0.0, 0.0, 0.0), lines_of(-0.69, 0.0, 0.0)
    arc = LaneArc(pose=HERE)
    for _ in range(5):
        arc = correct(arc, HERE, LaneLines(right=branch.right, left=straight.left), HALF_M, PARAMS)
    assert abs(arc.curvature_pm) < 0.02
    assert abs((HERE.inverse() @ arc.pose).y_m) < 0.01


def test_paint_that_is_no_line_of_the_lane_counts_for_nothing() -> None:
    arc = LaneArc(pose=HERE)
    after = correct(arc, HERE, lines_of(0.0, 0.3, 0.0), HALF_M, PARAMS)
    assert after.pose == abreast(arc, HERE).pose and after.curvature_pm == 0.0
    assert np.trace(after.covariance) > np.trace(arc.covariance)


def test_it_waits_for_the_arrow_and_follows_the_lane_from_pixels_alone() -> None:
    """The straight, the loop, the S-road and the straight back, past where a road branches off."""
    world = World(arrow_at_s=0.4)
    agent = LaneFollower(world.detect, 1.0)
    agent.start(mission())
    s_m, offsets, waited = -0.65, [], 0.0
    for truth, command in drive(world, agent, 27.0):
        s_m = progress(s_m, truth, LAP)
        offsets.append(float(LAP.project([(truth.x_m, truth.y_m)], around_s_m=s_m)[1][0]))
        waited += 0.05 * (command.v_mps == 0.0)
    assert 0.55 < waited < 0.7
    assert s_m > 25.0
    assert np.abs(offsets).max() < 0.10


def test_what_it_tells_of_its_place_is_dead_reckoning() -> None:
    world = World(radius_scale=0.99)
    agent = LaneFollower(world.detect, 1.0)
    agent.start(mission())
    *_, (truth, command) = drive(world, agent, 4.5)
    driven_m = math.hypot(truth.x_m + 0.65, truth.y_m + 2.6125)
    assert driven_m > 3.0
    assert command.pose_world_robot.x_m - truth.x_m == pytest.approx(driven_m / 99, abs=0.02)
