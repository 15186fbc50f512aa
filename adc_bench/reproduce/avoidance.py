"""Boxes in the lane, gone round by the thesis' driver with its rule; its PID drives between them. True pose, laser."""

from collections import deque

import msgspec
import numpy as np
import shapely

from adc_bench.evaluate.rules import RULES
from adc_bench.geometry import Pose2
from adc_bench.reproduce.laps import COURSE, START, mission, simulation_of
from adc_bench.stack.path_following import progress
from adc_bench.stack.pilots import start_s
from adc_bench.stack.prediction import at_rest, send, when_acting
from adc_bench.stack.thesis_pilot import ThesisPilot
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.drawing import box_floor
from adc_bench.world.frame import Detections
from adc_bench.world.layout import BoxPlace, Layout

BEYOND_M, GIVEN_UP_S = 4.0, 90.0
STRAIGHT_ON = Detections(
    boxes_px=np.zeros((1, 4), dtype=np.float32),
    scores=np.ones(1, dtype=np.float32),
    category_ids=np.array([CATEGORY_ID["panel_up"]], dtype=np.int64),
    keypoints_px=np.zeros((1, 4, 2), dtype=np.float32),
    keypoint_sigma_px=np.ones((1, 4), dtype=np.float32),
    keypoint_scores=np.zeros((1, 4), dtype=np.float32),
)


class Avoidance(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A drive past boxes, by control step: time, true pose, whether the behaviour steered, and the outline's distance
    to the nearest box where it first stood. `passed` if the robot came past them all.
    """

    boxes: tuple[BoxPlace, ...]
    time_s: tuple[float, ...]
    truth: tuple[Pose2, ...]
    avoiding: tuple[bool, ...]
    clearance_m: tuple[float, ...]
    contacts: int
    passed: bool


def go_round(boxes_s_m: tuple[float, ...], speed_mps: float, seed: int) -> Avoidance:
    """Return a drive past boxes in the middle of the lane at these arc lengths, straight on at crosswalks."""
    boxes = tuple(_box(COURSE.lap.pose(s_m)) for s_m in boxes_s_m)
    task = msgspec.structs.replace(mission(), elements=("boxes",))
    simulation = simulation_of(seed, Layout(name="boxes", boxes=boxes))
    pilot = ThesisPilot(mission=task, speed_mps=speed_mps)
    state, under_way, coming = pilot.start(), at_rest(task.control_period_s, task.latency_s), deque([(0.0, 0.0)])
    floor = shapely.union_all([box_floor(box) for box in boxes])
    s_m, end_m, contacts = start_s(COURSE.lap, START), boxes_s_m[-1] + BEYOND_M, 0
    rows: list[tuple[float, Pose2, bool, float]] = []
    while s_m < end_m and simulation.time_s < GIVEN_UP_S:
        pose, laser = simulation.state().pose_world_robot, simulation.read_sensors().laser
        s_m = progress(s_m, pose, COURSE.lap)
        if pilot.looks(state):
            state = pilot.look(state, pose, STRAIGHT_ON)
        if laser is not None:
            state = pilot.see(state, pose, laser)
        rows.append((simulation.time_s, pose, state.around is not None, float(_outline(pose).distance(floor))))
        there, motion = when_acting(under_way, task.robot, pose, task.control_period_s)
        state, command = pilot.steer(state, there, motion)
        under_way = send(under_way, task.robot, command, task.control_period_s)
        simulation.advance(*coming.popleft())
        coming.append((command.v_mps, command.omega_radps))
        contacts += len(simulation.take_contacts())
    time_s, truth, active, clearance_m = zip(*rows, strict=True)
    return Avoidance(
        boxes=boxes,
        time_s=time_s,
        truth=truth,
        avoiding=active,
        clearance_m=clearance_m,
        contacts=contacts,
        passed=s_m >= end_m,
    )


def _box(pose: Pose2) -> BoxPlace:
    return BoxPlace(x_m=pose.x_m, y_m=pose.y_m, yaw_rad=pose.yaw_rad)


def _outline(pose: Pose2) -> shapely.Polygon:
    x_m, y_m = RULES.robot.length_m / 2, RULES.robot.width_m / 2
    return shapely.Polygon(pose.transform([(x_m, y_m), (-x_m, y_m), (-x_m, -y_m), (x_m, -y_m)]))
