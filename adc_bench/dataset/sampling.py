"""From a split and a frame index to the arena and the robot's pose in it; each depends on nothing else.

Scenario k holds the frames from k x frames_per_scenario on. Light levels take turns from scenario to scenario, cameras
from frame to frame, and the panel signs go round within a scenario, so every short run has all of them.
"""

import math
from dataclasses import dataclass

import numpy as np

from adc_bench.dataset.split import Split
from adc_bench.geometry import Pose2, Pose3, rotation_zyx
from adc_bench.world.arena import Tunnel
from adc_bench.world.categories import PANEL_SIGNS, PanelSign
from adc_bench.world.course import Course
from adc_bench.world.layout import Layout
from adc_bench.world.look import draw_look
from adc_bench.world.robot import RobotParams, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.streams import stream

GOLDEN = (math.sqrt(5) - 1) / 2
ROBOT_RADIUS_M = 0.30  # a circle about the origin that holds the body
ROBOT_TOP_M = 0.85  # with the camera mast
APPROACH_M = (0.3, 4.5)
LEFT_LANE_SHARE, REVERSED_SHARE = 0.3, 0.25
OUTLIER_SHARE = 0.1
LATERAL_SD_M, LATERAL_OUTLIER_SD_M = 0.15, 0.45
HEADING_SD_RAD, HEADING_OUTLIER_SD_RAD = math.radians(8), math.radians(35)
BODY_TILT_SD_RAD = math.radians(0.3)


@dataclass(frozen=True, kw_only=True, eq=False)
class FramePlan:
    """What a frame shows: the camera, the sign on both panels, and the robot's pose with its body's pitch and roll."""

    index: int
    camera: str
    panel_sign: PanelSign
    pose_world_robot: Pose3


def scenario_number(split: Split, index: int) -> int:
    """Return the number of the scenario that a frame belongs to."""
    return index // split.frames_per_scenario


def draw_scenario(split: Split, number: int, rig: SensorRig) -> Scenario:
    """Return the split's scenario of this number."""
    seed = split.seed_first + number
    levels = split.looks.light_levels
    robot = RobotParams()
    return Scenario(
        name=f"{split.name}-{number:05d}",
        seed=seed,
        look=draw_look(split.looks, stream(seed, "look"), levels[number % len(levels)]),
        robot_truth=draw_robot_truth(robot, stream(seed, "robot")),
        panel_sign=PANEL_SIGNS[number % len(PANEL_SIGNS)],
        layout=Layout(tunnel=_draw_tunnel(stream(seed, "tunnel")) if _has_tunnel(split, number) else None),
        robot=robot,
        rig=rig,
    )


def draw_frame(split: Split, scenario: Scenario, index: int) -> FramePlan:
    """Return the plan of a frame that belongs to this scenario."""
    number, k = divmod(index, split.frames_per_scenario)
    cameras = scenario.rig.cameras
    # The sign moves on once both cameras had it, so that each camera sees all of them.
    sign = PANEL_SIGNS[(number + k // len(cameras)) % len(PANEL_SIGNS)]
    return FramePlan(
        index=index,
        camera=cameras[k % len(cameras)].name,
        panel_sign=sign,
        pose_world_robot=_draw_pose(split, scenario, stream(scenario.seed, "pose", k)),
    )


def crosswalk_passages_m(course: Course) -> tuple[float, float]:
    """Return the two arc lengths of the lap at which it passes the crosswalk's middle."""
    back = next(gate.s_m for gate in course.gates if gate.name == "crosswalk_back")
    return 0.0, back


def _has_tunnel(split: Split, number: int) -> bool:
    # Evenly spread numbers in 0..1: the share holds in every stretch of scenarios and at every light level.
    levels = len(split.looks.light_levels)
    turn, level = divmod(number, levels)
    spread = ((level + turn) % levels + turn * GOLDEN % 1.0) / levels
    return spread >= 1.0 - split.tunnel_share


def _draw_tunnel(rng: np.random.Generator) -> Tunnel:
    """Half of the tunnels stand on a loop, half before the crosswalk and often over it."""
    course = Course()
    length_m = float(rng.uniform(2.0, 4.0))
    if rng.random() < 0.5:
        start_m = float(rng.choice(crosswalk_passages_m(course))) - float(rng.uniform(1.0, 3.0))
    else:
        loop = int(rng.choice([1, 4]))  # the lap's pieces along the two loops
        start_m = float(course.lap.knots_m[loop] + rng.uniform(0.0, course.lap.pieces[loop].length_m - length_m))
    return Tunnel(start_s_m=start_m % course.lap.length_m, length_m=length_m)


def _draw_pose(split: Split, scenario: Scenario, rng: np.random.Generator) -> Pose3:
    walls = _obstructions(scenario)
    pose = _draw_place(split, scenario, rng)
    while not _is_clear(pose, walls):
        pose = _draw_place(split, scenario, rng)
    pitch_rad, roll_rad = (float(tilt) for tilt in BODY_TILT_SD_RAD * rng.standard_normal(2))
    return Pose3(
        rotation=rotation_zyx(pose.yaw_rad, pitch_rad, roll_rad), translation_m=np.array([pose.x_m, pose.y_m, 0.0])
    )


def _draw_place(split: Split, scenario: Scenario, rng: np.random.Generator) -> Pose2:
    """Draw a pose on or around a lane, in either direction."""
    course = scenario.course
    reverse = rng.random() < REVERSED_SHARE
    s_m = _draw_arc_length(split, scenario, rng, -1.0 if reverse else 1.0)
    outlier = rng.random() < OUTLIER_SHARE
    lateral_m = (LATERAL_OUTLIER_SD_M if outlier else LATERAL_SD_M) * rng.standard_normal()
    turn_rad = (HEADING_OUTLIER_SD_RAD if outlier else HEADING_SD_RAD) * rng.standard_normal()
    if rng.random() < LEFT_LANE_SHARE:
        lateral_m += course.spec.radius_outer_m - course.spec.radius_centre_m
    yaw_rad = float(turn_rad) + (math.pi if reverse else 0.0)
    return course.lap.pose(s_m) @ Pose2(x_m=0.0, y_m=float(lateral_m), yaw_rad=yaw_rad)


def _draw_arc_length(split: Split, scenario: Scenario, rng: np.random.Generator, direction: float) -> float:
    """Draw where along the lap: before the crosswalk, in or before the tunnel if there is one, or anywhere."""
    lap, tunnel = scenario.course.lap, scenario.tunnel
    where, spot = rng.random(), rng.random()
    if where < split.crosswalk_share:
        near, far = APPROACH_M
        return float(rng.choice(crosswalk_passages_m(scenario.course))) - direction * (
            near + (far - near) * float(spot)
        )
    if tunnel and rng.random() < 0.7:
        return tunnel.start_s_m - 1.0 + (tunnel.length_m + 1.0) * float(spot)
    return lap.length_m * float(spot)


def _obstructions(scenario: Scenario) -> np.ndarray:
    """Return (n, 5) x, y, yaw, half length, half width of every solid that the robot could run into."""
    return np.array(
        [
            (solid.centre_m[0], solid.centre_m[1], solid.yaw_rad, solid.size_m[0] / 2, solid.size_m[1] / 2)
            for solid in scenario.solids
            if solid.kind != "panel" and solid.centre_m[2] - solid.size_m[2] / 2 < ROBOT_TOP_M
        ]
    )


def _is_clear(pose: Pose2, obstructions: np.ndarray) -> bool:
    x, y, yaw, half_length, half_width = obstructions.T
    dx, dy = pose.x_m - x, pose.y_m - y
    along = np.abs(np.cos(yaw) * dx + np.sin(yaw) * dy) - half_length
    across = np.abs(np.cos(yaw) * dy - np.sin(yaw) * dx) - half_width
    gap = np.hypot(np.maximum(along, 0), np.maximum(across, 0))
    return bool(gap.min() > ROBOT_RADIUS_M)
