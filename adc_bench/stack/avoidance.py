"""Going round an obstacle by the thesis' rule (section 6.4): beside its nearest point, by an angle that grows near it.

    beta = alpha_obs +- (pi / 2) / exp(a l_obs)

is the direction to steer for, seen from the robot; alpha_obs is the direction of the nearest return and l_obs its
distance. Here l_obs counts from `reach_m` off: along a wall at its side the rule comes to rest there, while the thesis'
own distance, that of the sensor, would lead the robot's corner into what it goes round. The behaviour begins when
something wide enough is near and ahead; it ends when nothing is there any more, nor about the direction in which the
path leads on. It lasts for a while at least, so that the changes to and fro are bounded.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import wrap_array_rad, wrap_rad
from adc_bench.stack.laser_clusters import Cluster
from adc_bench.world.robot import Motion

Array = NDArray[np.float64]
Side = Literal["left", "right"]


@dataclass(frozen=True, kw_only=True)
class AvoidanceParams:
    """The thesis' figures; ours are `reach_m`, the speed, and what bounds the changes."""

    a_pm: float = 0.9
    width_m: float = 0.15
    near_m: float = 2.0
    ahead_rad: float = math.radians(20)
    free_rad: float = math.radians(25)  # about the direction of the path, for the behaviour to end
    kp: float = 1.6
    reach_m: float = 0.35
    speed_mps: float = 0.5
    slow_rad: float = math.radians(60)  # turning by so much it stands
    turn_max_radps: float = 1.5
    dwell_s: float = 0.5


@dataclass(frozen=True, kw_only=True)
class Avoiding:
    """Whether an obstacle is being gone round, since when, and with it on which hand the robot passes."""

    side: Side
    since_s: float | None = None

    @property
    def active(self) -> bool:
        """Whether the behaviour steers."""
        return self.since_s is not None


def avoid(
    state: Avoiding, found: Sequence[Cluster], path_rad: float, time_s: float, params: AvoidanceParams
) -> tuple[Avoiding, Motion | None]:
    """Return the next state and the command, None while the way is free.

    `found` is what the scan met, `path_rad` the direction, seen from the robot, of a point ahead on the path.
    """
    blocked = ahead(found, params) is not None
    if not state.active:
        state = replace(state, since_s=time_s) if blocked else state
    elif not blocked and _may_leave(state, found, path_rad, time_s, params):
        state = replace(state, since_s=None)
    return state, _round(state.side, found, path_rad, params) if state.active else None


def _may_leave(
    state: Avoiding, found: Sequence[Cluster], path_rad: float, time_s: float, params: AvoidanceParams
) -> bool:
    assert state.since_s is not None, "only an active behaviour ends"
    free = _nearest_in_cone(found, path_rad, params.free_rad, params.near_m) is None
    return free and time_s - state.since_s >= params.dwell_s


def ahead(found: Sequence[Cluster], params: AvoidanceParams) -> Array | None:
    """Return the nearest return (2,), in the robot frame, of what the behaviour begins for; None if the way is free."""
    wide = [cluster for cluster in found if cluster.width_m >= params.width_m]
    return _nearest_in_cone(wide, 0.0, params.ahead_rad, params.near_m)


def _nearest_in_cone(found: Sequence[Cluster], towards_rad: float, half_rad: float, near_m: float) -> Array | None:
    """Return the nearest return (2,) that lies near and within an angle about a direction, None if there is none."""
    points = np.concatenate([np.zeros((0, 2)), *(cluster.points_robot for cluster in found)])
    distances = np.hypot(points[:, 0], points[:, 1])
    apart = np.abs(wrap_array_rad(np.arctan2(points[:, 1], points[:, 0]) - towards_rad))
    inside = (distances < near_m) & (apart < half_rad)
    return np.asarray(points[np.argmin(np.where(inside, distances, np.inf))]) if inside.any() else None


def _round(side: Side, found: Sequence[Cluster], path_rad: float, params: AvoidanceParams) -> Motion:
    """Return the command towards beta; along the path if there is nothing to go round.

    Of several things near the one counts that asks for the most: beside it the robot passes the others too. What
    stands on the side of passing, aside of straight ahead, is no part of what is gone round.
    """
    hand = 1 if side == "left" else -1
    wanted = []
    for cluster in found:
        distances = np.where(hand * cluster.bearings_rad < params.ahead_rad, _distances(cluster), np.inf)
        k = int(np.argmin(distances))
        if distances[k] < params.near_m:
            wanted.append(steer_rad(float(cluster.bearings_rad[k]), float(distances[k]), side, params))
    beta = max(wanted, key=lambda angle: hand * angle, default=path_rad)
    turn = max(-params.turn_max_radps, min(params.turn_max_radps, params.kp * beta))
    return Motion(v_mps=params.speed_mps * max(1 - abs(beta) / params.slow_rad, 0.0), omega_radps=turn)


def steer_rad(bearing_rad: float, distance_m: float, side: Side, params: AvoidanceParams) -> float:
    """Return beta, the direction to steer for, seen from the robot."""
    away = math.pi / 2 * math.exp(-params.a_pm * (distance_m - params.reach_m))
    return wrap_rad(bearing_rad + min(away, math.pi) * (1 if side == "left" else -1))


def _distances(cluster: Cluster) -> Array:
    return np.asarray(np.hypot(cluster.points_robot[:, 0], cluster.points_robot[:, 1]), dtype=np.float64)
