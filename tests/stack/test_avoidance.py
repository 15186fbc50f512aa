"""Going round things by the thesis' rule: the rule itself, its beginning and end, and drives past made things."""

import math

import numpy as np
import pytest
from laser_hall import LASER, Hall, moved, thing

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.avoidance import AvoidanceParams, Avoiding, Side, avoid, steer_rad
from adc_bench.stack.laser_clusters import Cluster, clusters
from adc_bench.world.robot import Motion

PARAMS = AvoidanceParams()
PERIOD_S = 0.1
ROUND = [thing(3.0, 0.0, 0.6, 0.6, shape="cylinder")]
CONVEX = [thing(3.0, 0.1, 0.6, 0.6, math.radians(30))]
CONCAVE = [thing(3.2, 0.0, 0.1, 0.9), thing(2.95, -0.42, 0.5, 0.1), thing(2.95, 0.42, 0.5, 0.1)]
DOUBLE = [thing(3.0, 0.0, 0.6, 0.6), thing(6.0, 0.1, 0.6, 0.6)]


def wall(distance_m: float, width_m: float, bearing_rad: float = 0.0) -> Cluster:
    """Return a cluster square to a direction."""
    across = np.linspace(-width_m / 2, width_m / 2, 15)
    points = np.column_stack([np.full(15, distance_m), across])
    return Cluster(points_robot=Pose2(x_m=0.0, y_m=0.0, yaw_rad=bearing_rad).transform(points))


def drive(things: list, side: Side, seconds: float = 40.0) -> tuple[np.ndarray, float, int]:
    """Drive along the x axis past things; return the poses, the least clearance and how often the behaviour began."""
    hall, pose, state = Hall(things), Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), Avoiding(side=side)
    poses, clearance_m, begun = [], math.inf, 0
    for step in range(round(seconds / PERIOD_S)):
        path_rad = wrap_rad(math.atan2(-pose.y_m, 1.0) - pose.yaw_rad)
        was, found = state.active, clusters(hall.scan(pose), LASER)
        state, command = avoid(state, found, path_rad, step * PERIOD_S, PARAMS)
        begun += state.active and not was
        pose = moved(pose, command or Motion(v_mps=0.5, omega_radps=PARAMS.kp * path_rad), PERIOD_S)
        clearance_m = min(clearance_m, hall.clearance_m(pose))
        poses.append((pose.x_m, pose.y_m, pose.yaw_rad))
    return np.array(poses), clearance_m, begun


@pytest.mark.parametrize("things", [ROUND, CONVEX, CONCAVE, DOUBLE], ids=["round", "convex", "concave", "double"])
@pytest.mark.parametrize("side", ["left", "right"])
def test_it_passes_on_the_asked_side_and_comes_back(things: list, side: Side) -> None:
    poses, clearance_m, begun = drive(things, side)
    assert clearance_m > 0.03
    beside = poses[np.argmin(np.abs(poses[:, 0] - 3.0)), 1]
    assert beside > 0.3 if side == "left" else beside < -0.3
    assert poses[-1, 0] > 8.0 and abs(poses[-1, 1]) < 0.1
    assert 1 <= begun <= 2 * len(things)


def test_the_rule_is_the_thesis_own_beyond_the_reach() -> None:
    """beta = alpha + (pi / 2) / exp(a l), the distance counted from `reach_m` off."""
    beta = steer_rad(0.1, 1.0 + PARAMS.reach_m, "left", PARAMS)
    assert beta == pytest.approx(0.1 + math.pi / 2 / math.exp(0.9))
    assert steer_rad(-0.1, 1.0 + PARAMS.reach_m, "right", PARAMS) == pytest.approx(-beta)
    assert steer_rad(0.0, PARAMS.reach_m, "left", PARAMS) == pytest.approx(math.pi / 2)


@pytest.mark.parametrize(
    ("cluster", "begins"),
    [
        (wall(1.9, 0.16), True),
        (wall(1.9, 0.14), False),
        (wall(2.1, 0.6), False),
        (wall(1.5, 0.3, math.radians(15)), True),
        (wall(1.5, 0.3, math.radians(30)), False),
    ],
)
def test_it_begins_when_something_wide_is_near_and_ahead(cluster: Cluster, begins: bool) -> None:
    state, command = avoid(Avoiding(side="left"), [cluster], 0.0, 1.0, PARAMS)
    assert state.active == begins and (command is not None) == begins


def test_it_lasts_while_the_path_leads_through_and_at_least_its_dwell() -> None:
    begun = Avoiding(side="left", since_s=1.0)
    aside = wall(1.0, 0.3, -1.2)
    assert avoid(begun, [aside], -1.2, 5.0, PARAMS)[0].active
    assert avoid(begun, [aside], 0.0, 1.0 + PARAMS.dwell_s / 2, PARAMS)[0].active
    assert not avoid(begun, [aside], 0.0, 1.0 + PARAMS.dwell_s, PARAMS)[0].active


def test_changes_are_bounded_whatever_flickers() -> None:
    """A thing that is there in every other scan begins the behaviour at most once in a dwell."""
    state, begun = Avoiding(side="left"), 0
    for step in range(200):
        was = state.active
        state, _ = avoid(state, [wall(1.0, 0.3)] if step % 2 == 0 else [], 0.0, step * 0.05, PARAMS)
        begun += state.active and not was
    assert begun <= 200 * 0.05 / PARAMS.dwell_s
