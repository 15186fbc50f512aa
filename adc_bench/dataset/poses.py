"""Where the robot stands when a picture is taken: before the crosswalk, before signs and obstacles, or anywhere."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.split import Split
from adc_bench.geometry import Pose2, Pose3, rotation_zyx
from adc_bench.world.course import Course
from adc_bench.world.footprints import extents
from adc_bench.world.scenario import Scenario

Array = NDArray[np.float64]

ROBOT_RADIUS_M = 0.30  # a circle about the origin that holds the body
ROBOT_TOP_M = 0.85  # with the camera mast
APPROACH_M = (0.5, 4.8)
LEFT_LANE_SHARE, REVERSED_SHARE = 0.3, 0.25
IN_TUNNEL_SHARE = 0.7  # of the poses that are free to be anywhere
OUTLIER_SHARE = 0.1
LATERAL_SD_M, LATERAL_OUTLIER_SD_M = 0.15, 0.45
HEADING_SD_RAD, HEADING_OUTLIER_SD_RAD = math.radians(8), math.radians(35)
BODY_TILT_SD_RAD = math.radians(0.3)
OBJECT_DISTANCE_M = (0.6, 5.0)
OBJECT_ASIDE_RAD = math.radians(25)  # how far from straight ahead an object may be
FRONT_RAD = math.radians(60)  # from how far aside a board is looked at
CONES_AS_ONE = 3  # this many cones are looked at as often as one box or sign


class Target(NamedTuple):
    """A thing to look at: its place, and the way it faces if it has a front."""

    x_m: float
    y_m: float
    yaw_rad: float | None


def draw_pose(split: Split, scenario: Scenario, rng: np.random.Generator) -> Pose3:
    """Draw a pose of the robot, clear of all that stands, with the small pitch and roll of its body."""
    obstacles = _obstacles(scenario)
    pose = _draw_place(split, scenario, rng)
    while not _is_clear(pose, obstacles):
        pose = _draw_place(split, scenario, rng)
    pitch_rad, roll_rad = (float(tilt) for tilt in BODY_TILT_SD_RAD * rng.standard_normal(2))
    return Pose3(
        rotation=rotation_zyx(pose.yaw_rad, pitch_rad, roll_rad), translation_m=np.array([pose.x_m, pose.y_m, 0.0])
    )


def crosswalk_passages_m(course: Course) -> tuple[float, float]:
    """Return the two arc lengths of the lap at which it passes the crosswalk's middle."""
    return 0.0, course.crosswalk_back_m


def _draw_place(split: Split, scenario: Scenario, rng: np.random.Generator) -> Pose2:
    where = rng.random()
    if split.crosswalk_share <= where < split.crosswalk_share + split.objects_share:
        targets = _targets(scenario)
        if targets:
            return _draw_before(targets[int(rng.integers(len(targets)))], scenario.course, rng)
    return _draw_on_lane(scenario, bool(where < split.crosswalk_share), rng)


def _draw_on_lane(scenario: Scenario, before_crosswalk: bool, rng: np.random.Generator) -> Pose2:
    """Draw a pose on or around a lane, in either direction."""
    course = scenario.course
    reverse = rng.random() < REVERSED_SHARE
    s_m = _draw_arc_length(scenario, before_crosswalk, rng, -1.0 if reverse else 1.0)
    outlier = rng.random() < OUTLIER_SHARE
    lateral_m = (LATERAL_OUTLIER_SD_M if outlier else LATERAL_SD_M) * rng.standard_normal()
    turn_rad = (HEADING_OUTLIER_SD_RAD if outlier else HEADING_SD_RAD) * rng.standard_normal()
    if rng.random() < LEFT_LANE_SHARE:
        lateral_m += course.spec.radius_outer_m - course.spec.radius_centre_m
    yaw_rad = float(turn_rad) + (math.pi if reverse else 0.0)
    return course.lap.pose(s_m) @ Pose2(x_m=0.0, y_m=float(lateral_m), yaw_rad=yaw_rad)


def _draw_arc_length(scenario: Scenario, before_crosswalk: bool, rng: np.random.Generator, direction: float) -> float:
    """Draw where along the lap: before the crosswalk, in or before the tunnel if there is one, or anywhere."""
    lap, tunnel = scenario.course.lap, scenario.tunnel
    spot = float(rng.random())
    if before_crosswalk:
        near, far = APPROACH_M
        return float(rng.choice(crosswalk_passages_m(scenario.course))) - direction * (near + (far - near) * spot)
    if tunnel and rng.random() < IN_TUNNEL_SHARE:
        return tunnel.start_s_m - 1.0 + (tunnel.length_m + 1.0) * spot
    return lap.length_m * spot


def _targets(scenario: Scenario) -> list[Target]:
    """Return the signs, the boxes, and some of the cones."""
    signs = [Target(sign.x_m, sign.y_m, sign.yaw_rad) for sign in scenario.signs]
    bodies = {kind: [body.pose for body in scenario.bodies if body.kind == kind] for kind in ("box", "cone")}
    poses = [*(CONES_AS_ONE * bodies["box"]), *bodies["cone"]]
    return [*(CONES_AS_ONE * signs), *(Target(pose.x_m, pose.y_m, None) for pose in poses)]


def _draw_before(target: Target, course: Course, rng: np.random.Generator) -> Pose2:
    """Draw a pose on or around a lane from which the target is seen in front, at an evenly spread distance."""
    stations = _stations(course)
    away = stations[:, :2] - (target.x_m, target.y_m)
    distance_m = np.hypot(away[:, 0], away[:, 1])
    near_m, far_m = OBJECT_DISTANCE_M
    seen = (distance_m > near_m) & (distance_m < far_m)
    if target.yaw_rad is not None:
        seen &= np.cos(np.arctan2(away[:, 1], away[:, 0]) - target.yaw_rad) > math.cos(FRONT_RAD)
    wanted_m = float(rng.uniform(near_m, far_m))
    best = stations[np.argmin(np.where(seen, np.abs(distance_m - wanted_m), np.inf))]
    aside_m = LATERAL_SD_M * rng.standard_normal(2)
    x_m, y_m = best[0] + aside_m[0], best[1] + aside_m[1]
    bearing_rad = math.atan2(target.y_m - y_m, target.x_m - x_m)
    yaw_rad = bearing_rad + float(rng.uniform(-OBJECT_ASIDE_RAD, OBJECT_ASIDE_RAD))
    return Pose2(x_m=float(x_m), y_m=float(y_m), yaw_rad=yaw_rad)


@lru_cache(maxsize=2)
def _stations(course: Course) -> Array:
    """Return poses (n, 3) all along the lanes."""
    return np.concatenate([lane.sample(0.1) for lane in course.lanes.values()])


class _Obstacles(NamedTuple):
    """Rectangles on the floor that a robot could stand in: centres (n, 2), yaws (n,), half sizes (n, 2)."""

    centre: Array
    yaw: Array
    half: Array


@lru_cache(maxsize=2)
def _obstacles(scenario: Scenario) -> _Obstacles:
    """Return the footprints of all that stands lower than the robot's top, tapes included."""
    things = extents(scenario.solids, scenario.bodies)
    low = things.low[:, 2] < ROBOT_TOP_M
    places = {body.name: (body.pose.x_m, body.pose.y_m) for body in scenario.bodies}
    ends = np.array([(places[tape.first], places[tape.second]) for tape in scenario.tapes]).reshape(-1, 2, 2)
    along = ends[:, 1] - ends[:, 0]
    reach = np.stack([np.hypot(along[:, 0], along[:, 1]) / 2, np.zeros(len(along))], axis=1)
    return _Obstacles(
        centre=np.concatenate([things.centre[low], ends.mean(axis=1)]),
        yaw=np.concatenate([things.yaw[low], np.arctan2(along[:, 1], along[:, 0])]),
        half=np.concatenate([things.half[low], reach]),
    )


def _is_clear(pose: Pose2, obstacles: _Obstacles) -> bool:
    dx, dy = (np.array([pose.x_m, pose.y_m]) - obstacles.centre).T
    cos, sin = np.cos(obstacles.yaw), np.sin(obstacles.yaw)
    along = np.abs(cos * dx + sin * dy) - obstacles.half[:, 0]
    across = np.abs(cos * dy - sin * dx) - obstacles.half[:, 1]
    return bool(np.hypot(np.maximum(along, 0), np.maximum(across, 0)).min() > ROBOT_RADIUS_M)
