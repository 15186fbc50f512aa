"""Reading vertical signs: detections gathered where in the world they stand, and reported where the robot passes them.

All boards are as high, so that the angle between a box's upper and lower side tells how far away its board is.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.stack.reference_line import ReferenceLine
from adc_bench.world.categories import CATEGORY_ID, SIGNS, SignCategory
from adc_bench.world.frame import Detections
from adc_bench.world.sensors import CameraMount
from adc_bench.world.signs import BOARD_CENTRE_Z_M, BOARD_M

SIGN_OF_CATEGORY: dict[int, SignCategory] = {CATEGORY_ID[sign]: sign for sign in SIGNS}
FORGET_M = 5.0  # a board so far away again has been passed


@dataclass(frozen=True, kw_only=True)
class SignParams:
    """What is needed to believe a sign: names that agree, of a board as high as signs are, beside the lane."""

    least_score: float = 0.4
    pictures: int = 2
    height_error_m: float = 0.25
    range_max_m: float = 3.5
    same_m: float = 0.8
    ahead_m: float = 1.2
    behind_m: float = 0.6
    beside_m: float = 1.3


@dataclass(frozen=True, kw_only=True)
class SeenSign:
    """A board on the floor's map where it was seen last, and the names that it was given with the weight of each."""

    x_m: float
    y_m: float
    names: tuple[tuple[SignCategory, float], ...]
    reported: bool = False

    @property
    def name(self) -> SignCategory:
        """The name of the greatest weight."""
        weights: dict[SignCategory, float] = {}
        for name, weight in self.names:
            weights[name] = weights.get(name, 0.0) + weight
        return max(weights, key=lambda name: weights[name])


@dataclass(frozen=True, kw_only=True)
class SignsState:
    """The boards about the robot, and the sign to be reported now."""

    seen: tuple[SeenSign, ...] = ()
    report: SignCategory | None = None


def read_signs(
    state: SignsState,
    detections: Detections,
    mount: CameraMount,
    pose: Pose2,
    lane: ReferenceLine,
    s_m: float,
    params: SignParams,
) -> SignsState:
    """Return the state after one more picture from `pose`, at an arc length of the line that is driven.

    A board is reported once, as late as is safe, for the near pictures tell most: from `ahead_m` before it on.
    """
    seen = tuple(board for board in state.seen if math.hypot(board.x_m - pose.x_m, board.y_m - pose.y_m) < FORGET_M)
    for board in boards(detections, mount, pose, params):
        seen = _joined(seen, board, params)
    for index, board in enumerate(seen):
        sure = len(board.names) >= params.pictures and not board.reported
        if sure and _is_passed(board, lane, s_m, params):
            seen = (*seen[:index], replace(board, reported=True), *seen[index + 1 :])
            return SignsState(seen=seen, report=board.name)
    return SignsState(seen=seen)


def boards(detections: Detections, mount: CameraMount, pose: Pose2, params: SignParams) -> list[SeenSign]:
    """Return the boards of one picture on the map, if near enough and as high above the floor as signs are."""
    found = []
    pose_robot_camera = mount.pose_robot_camera()
    for box, score, category in zip(detections.boxes_px, detections.scores, detections.category_ids, strict=True):
        name = SIGN_OF_CATEGORY.get(int(category))
        if name is None or score < params.least_score:
            continue
        x0, y0, x1, y1 = (float(v) for v in box)
        rays = mount.camera().rays([((x0 + x1) / 2, y0), ((x0 + x1) / 2, y1)]) @ pose_robot_camera.rotation.T
        top, bottom = rays[:, 2] / np.hypot(rays[:, 0], rays[:, 1])
        away_m = BOARD_M / max(float(top - bottom), 1e-6)
        height_m = mount.z_m + away_m * float(top + bottom) / 2
        if away_m > params.range_max_m or abs(height_m - BOARD_CENTRE_Z_M) > params.height_error_m:
            continue
        bearing = math.atan2(float(rays[:, 1].mean()), float(rays[:, 0].mean()))
        at = [(mount.x_m + away_m * math.cos(bearing), away_m * math.sin(bearing))]
        ((x_m, y_m),) = pose.transform(at).tolist()
        found.append(SeenSign(x_m=x_m, y_m=y_m, names=((name, float(score) / away_m**2),)))
    return found


def _joined(seen: tuple[SeenSign, ...], board: SeenSign, params: SignParams) -> tuple[SeenSign, ...]:
    """Return the boards with one more sighting, joined to the nearest board if that is near enough to be the same."""
    away_m = [math.hypot(other.x_m - board.x_m, other.y_m - board.y_m) for other in seen]
    if not seen or min(away_m) > params.same_m:
        return (*seen, board)
    index = away_m.index(min(away_m))
    joined = replace(board, names=(*seen[index].names, *board.names), reported=seen[index].reported)
    return (*seen[:index], joined, *seen[index + 1 :])


def _is_passed(board: SeenSign, lane: ReferenceLine, s_m: float, params: SignParams) -> bool:
    """Return whether a board stands beside the lane, and the robot is about to pass it or just did."""
    near: NDArray[np.bool_] = np.abs(lane.s_m - s_m) <= params.range_max_m
    away_m = np.hypot(lane.x_m[near] - board.x_m, lane.y_m[near] - board.y_m)
    ahead_m = float(lane.s_m[near][away_m.argmin()]) - s_m
    return bool(-params.behind_m <= ahead_m <= params.ahead_m and away_m.min() <= params.beside_m)
