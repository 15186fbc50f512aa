"""What stands in a driver's way, and what of a route's course it leaves free."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Path
from adc_bench.world.footprints import extents
from adc_bench.world.robot import RobotParams
from adc_bench.world.scenario import Scenario
from adc_bench.world.solids import Body

Array = NDArray[np.float64]
ROBOT_TOP_M = 0.85  # with the camera mast
CLEARANCE_M = 0.04  # that a plan keeps
EVERY = 4  # poses: one in so many is looked at


def taken_floor(scenario: Scenario, bodies: Sequence[Body]) -> shapely.Geometry:
    """Return the floor under these bodies and all other things lower than the robot's top, tapes included."""
    things = extents(scenario.solids, bodies)
    low = [things.footprint(k) for k in range(len(things.owner)) if things.low[k, 2] < ROBOT_TOP_M]
    places = {body.name: (body.pose.x_m, body.pose.y_m) for body in scenario.bodies}
    tapes = [shapely.LineString([places[tape.first], places[tape.second]]) for tape in scenario.tapes]
    taken = shapely.union_all([*low, *tapes])
    shapely.prepare(taken)
    return taken


def outlines(poses: Array, robot: RobotParams, margin_m: float = 0.0) -> Array:
    """Return the robot's outlines at poses (n, 3) as an array (n,) of polygons, `margin_m` wider all round."""
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * (robot.length_m / 2, robot.width_m / 2)
    corners = corners + np.sign(corners) * margin_m
    cos, sin = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    x = poses[:, 0, None] + cos * corners[:, 0] - sin * corners[:, 1]
    y = poses[:, 1, None] + sin * corners[:, 0] + cos * corners[:, 1]
    polygons: Array = shapely.polygons(np.stack([x, y], axis=2))
    return polygons


def is_free(poses: Array, robot: RobotParams, taken: shapely.Geometry) -> bool:
    """Return whether a robot at these poses (n, 3) keeps clear of what is taken."""
    return not bool(shapely.intersects(taken, outlines(poses[::EVERY], robot, CLEARANCE_M)).any())


def passes_m(path: Path, stations_m: Array, x_m: float, y_m: float, within_m: float) -> list[tuple[float, float]]:
    """Return (arc length, offset to the left) at which a path passes a point nearer than `within_m`, in order."""
    poses = path.poses(stations_m)
    ahead, left = x_m - poses[:, 0], y_m - poses[:, 1]
    distance = np.hypot(ahead, left)
    near = np.concatenate([[False], distance < within_m, [False]])
    edges = np.flatnonzero(near[1:] != near[:-1]).reshape(-1, 2)
    found = []
    for first, last in edges:
        k = first + int(np.argmin(distance[first:last]))
        offset = np.cos(poses[k, 2]) * left[k] - np.sin(poses[k, 2]) * ahead[k]
        found.append((float(stations_m[k]), float(offset)))
    return found
