"""Vertical signs drawn as boxes in the pictures that a robot takes as it passes them."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from driven_robot import COURSE, START

from adc_bench.geometry import Pose2
from adc_bench.stack.reference_line import rounded
from adc_bench.stack.sign_reading import SignParams, SignsState, boards, read_signs
from adc_bench.world.categories import CATEGORY_ID, SIGNS, SignCategory
from adc_bench.world.frame import Detections
from adc_bench.world.sensors import CameraMount, SensorRig
from adc_bench.world.signs import BOARD_CENTRE_Z_M, BOARD_M, VerticalSign, sign_places

MOUNT = next(mount for mount in SensorRig().cameras if mount.name == "panel")
LANE = rounded(COURSE.lap, 0.0, 20.0)
AT = VerticalSign(name="sign", sign="sign_cattle", x_m=3.0, y_m=START.y_m - 0.6, yaw_rad=math.pi)


def box_of(sign: VerticalSign, pose: Pose2, mount: CameraMount = MOUNT, z_m: float = BOARD_CENTRE_Z_M) -> list[float]:
    """Return the box around a board that faces the robot, nan where it is behind the picture."""
    half = BOARD_M / 2
    across = np.array([-math.sin(sign.yaw_rad), math.cos(sign.yaw_rad)]) * half
    corners = [
        (sign.x_m + side * across[0], sign.y_m + side * across[1], z_m + up * half)
        for side in (1, -1)
        for up in (1, -1)
    ]
    floor = pose.inverse().transform([corner[:2] for corner in corners])
    in_robot = np.column_stack([floor, [corner[2] for corner in corners]])
    camera = mount.pose_robot_camera()
    pixels = mount.camera().project((in_robot - camera.translation_m) @ camera.rotation)
    return [*pixels.min(axis=0).tolist(), *pixels.max(axis=0).tolist()]


def seen(*named: tuple[SignCategory, list[float]], score: float = 0.9) -> Detections:
    """Return detections of signs in boxes, those that lie in the picture."""
    inside = [(name, box) for name, box in named if np.isfinite(box).all() and box[0] >= 0 and box[2] <= MOUNT.width_px]
    count = len(inside)
    return Detections(
        boxes_px=np.array([box for _, box in inside], dtype=np.float32).reshape(-1, 4),
        scores=np.full(count, score, dtype=np.float32),
        category_ids=np.array([CATEGORY_ID[name] for name, _ in inside], dtype=np.int64),
        keypoints_px=np.zeros((count, 4, 2), dtype=np.float32),
        keypoint_sigma_px=np.ones((count, 4), dtype=np.float32),
        keypoint_scores=np.zeros((count, 4), dtype=np.float32),
    )


def pass_by(look: Callable[[Pose2], Detections], stations_m: Sequence[float]) -> list[tuple[float, SignCategory]]:
    """Return the reports of a robot in the lane that takes a picture at each of these arc lengths."""
    state, reports = SignsState(), []
    for s_m in stations_m:
        pose = LANE.pose(s_m)
        state = read_signs(state, look(pose), MOUNT, pose, LANE, s_m, SignParams())
        reports += [(s_m, state.report)] if state.report else []
    return reports


STATIONS_M = np.arange(0.0, 19.0, 0.44).tolist()


@pytest.mark.parametrize("away_m", [1.0, 2.0, 3.0])
def test_a_box_tells_where_its_board_stands(away_m: float) -> None:
    pose = Pose2(x_m=AT.x_m - away_m, y_m=START.y_m, yaw_rad=0.0)
    (board,) = boards(seen(("sign_cattle", box_of(AT, pose))), MOUNT, pose, SignParams())
    assert math.hypot(board.x_m - AT.x_m, board.y_m - AT.y_m) < 0.06 * away_m


def test_a_sign_is_reported_once_where_it_is_passed() -> None:
    ((s_m, name),) = pass_by(lambda pose: seen(("sign_cattle", box_of(AT, pose))), STATIONS_M)
    assert name == "sign_cattle"
    assert -0.6 <= AT.x_m - s_m <= 1.2


def test_the_near_pictures_outvote_the_far_ones() -> None:
    def look(pose: Pose2) -> Detections:
        return seen(("sign_dip" if AT.x_m - pose.x_m > 2.0 else "sign_cattle", box_of(AT, pose)))

    assert [name for _, name in pass_by(look, STATIONS_M)] == ["sign_cattle"]


def test_one_picture_is_not_enough_and_neither_are_weak_ones() -> None:
    once = STATIONS_M[4]
    assert not pass_by(
        lambda pose: seen(("sign_cattle", box_of(AT, pose))) if pose == LANE.pose(once) else seen(), STATIONS_M
    )
    assert not pass_by(lambda pose: seen(("sign_cattle", box_of(AT, pose)), score=0.3), STATIONS_M)


@pytest.mark.parametrize(("y_m", "z_m"), [(2.0, BOARD_CENTRE_Z_M), (-0.6, 0.2), (-0.6, 1.6)])
def test_boards_far_from_the_lane_or_at_another_height_are_no_signs(y_m: float, z_m: float) -> None:
    elsewhere = VerticalSign(name="sign", sign="sign_cattle", x_m=3.0, y_m=START.y_m + y_m, yaw_rad=math.pi)
    assert not pass_by(lambda pose: seen(("sign_cattle", box_of(elsewhere, pose, z_m=z_m))), STATIONS_M[:12])


def test_all_signs_of_the_first_half_lap_are_read() -> None:
    signs = [
        VerticalSign(name=f"sign_{k}", sign=SIGNS[k], x_m=p.x_m, y_m=p.y_m, yaw_rad=p.yaw_rad)
        for k, p in enumerate(sign_places(COURSE.spec)[:3])
    ]

    def look(pose: Pose2) -> Detections:
        facing = [sign for sign in signs if math.cos(sign.yaw_rad - pose.yaw_rad) < -0.3]
        near = [sign for sign in facing if math.hypot(sign.x_m - pose.x_m, sign.y_m - pose.y_m) < 4.0]
        return seen(*[(sign.sign, box_of(sign, pose)) for sign in near])

    assert [name for _, name in pass_by(look, STATIONS_M)] == [sign.sign for sign in signs]
