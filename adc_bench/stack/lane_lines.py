"""The lines left and right of the lane: a Hough start, then windows that follow each line, picture after picture."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.stack.paint import Paint

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class LineParams:
    """How lines are started and followed; metres and radians on the floor."""

    foot_x_m: float = 0.7  # where "left" and "right" are told apart
    foot_tolerance_m: float = 0.35
    hough_length_m: float = 0.20
    hough_gap_m: float = 0.20
    hough_votes: int = 18
    hough_tries: int = 3
    hough_slant_rad: float = math.radians(40)
    window_length_m: float = 0.10
    window_half_width_m: float = 0.09
    window_points: int = 20
    line_sd_m: float = 0.024  # paint spread wider than this across is no 5 cm line
    turn_share: float = 0.5
    turn_max_rad: float = 0.35
    gap_m: float = 0.45
    reach_m: float = 2.6


@dataclass(frozen=True, kw_only=True, eq=False)
class LaneLine:
    """Middles of one line, (n, 2) in the robot frame, in order away from the robot, and its direction at the first."""

    points_robot: Array
    direction_rad: float


@dataclass(frozen=True, kw_only=True, eq=False)
class LaneLines:
    """The two lines of the driven lane; None where none is seen."""

    right: LaneLine | None = None
    left: LaneLine | None = None


def find_lane_lines(before: LaneLines, paint: Paint, half_lane_m: float, params: LineParams | None = None) -> LaneLines:
    """Return the lane's lines in this picture, starting where they were in the last one, else from Hough lines."""
    p = params or LineParams()
    found: dict[str, LaneLine | None] = {}
    segments: list[tuple[Array, float]] | None = None
    for side, offset_m in (("right", -half_lane_m), ("left", half_lane_m)):
        old: LaneLine | None = getattr(before, side)
        line = _from(old.points_robot[0], old.direction_rad, paint, offset_m, p) if old else None
        if line is None:
            segments = _hough_segments(paint, p) if segments is None else segments
            starts = sorted(segments, key=lambda s: abs(_foot(s[0], s[1], p) - offset_m))
            tries = (_from(*start, paint, offset_m, p) for start in starts[: p.hough_tries])
            line = next((candidate for candidate in tries if candidate is not None), None)
        found[side] = line
    return LaneLines(right=found["right"], left=found["left"])


def _from(start: Array, direction_rad: float, paint: Paint, offset_m: float, p: LineParams) -> LaneLine | None:
    """Return the line through `start`, followed both ways, or None where it is short or not this side's."""
    if abs(_foot(start, direction_rad, p) - offset_m) > p.foot_tolerance_m:
        return None
    ahead = _follow(paint, start, direction_rad, p)
    behind = _follow(paint, start, direction_rad + math.pi, p)
    points = np.array([*reversed(behind), *ahead[1:]] if behind and ahead else [*reversed(behind), *ahead])
    if len(points) < 3:
        return None
    first = points[min(3, len(points) - 1)] - points[0]
    direction = math.atan2(first[1], first[0])
    if abs(_foot(points[0], direction, p) - offset_m) > p.foot_tolerance_m:
        return None
    return LaneLine(points_robot=points, direction_rad=direction)


def _foot(point: Array, direction_rad: float, p: LineParams) -> float:
    """Return the y at which the straight continuation passes x = foot_x_m; infinite if it runs across."""
    if abs(math.cos(direction_rad)) < 0.3:
        return math.inf
    return float(point[1] + (p.foot_x_m - point[0]) * math.tan(direction_rad))


def _hough_segments(paint: Paint, p: LineParams) -> list[tuple[Array, float]]:
    """Return (near end, direction) of the straight segments that run more or less ahead."""
    cell = paint.region.cell_m
    lines = cv2.HoughLinesP(
        paint.mask.astype(np.uint8) * 255,
        rho=2,
        theta=np.pi / 90,
        threshold=p.hough_votes,
        minLineLength=p.hough_length_m / cell,
        maxLineGap=p.hough_gap_m / cell,
    )
    segments = []
    for ends in () if lines is None else np.asarray(lines).reshape(-1, 2, 2):
        near, far = sorted(paint.region.points(ends), key=lambda point: float(point[0]))
        direction = math.atan2(far[1] - near[1], far[0] - near[0])
        if abs(direction) < p.hough_slant_rad:
            segments.append((near, direction))
    return segments


def _follow(paint: Paint, start: Array, direction_rad: float, p: LineParams) -> list[Array]:
    """Return the middles of the windows laid end to end along the line from `start`, as far as there is paint."""
    centre, direction = start, direction_rad
    found: list[Array] = []
    since_m = 0.0
    while since_m <= p.gap_m and len(found) * p.window_length_m < p.reach_m:
        middle = _middle_in_window(paint, centre, direction, p)
        if middle is None:
            since_m += p.window_length_m
        else:
            if found and np.hypot(*(middle - found[-1])) > p.window_length_m / 2:
                direction = _turned(direction, middle - found[-1], p)
            found.append(middle)
            centre, since_m = middle, 0.0
        centre = centre + p.window_length_m * np.array([math.cos(direction), math.sin(direction)])
    return found


def _turned(direction_rad: float, step: Array, p: LineParams) -> float:
    error = (math.atan2(step[1], step[0]) - direction_rad + math.pi) % (2 * math.pi) - math.pi
    return direction_rad + p.turn_share * max(-p.turn_max_rad, min(p.turn_max_rad, error))


def _middle_in_window(paint: Paint, centre: Array, direction_rad: float, p: LineParams) -> Array | None:
    """Return the mean of the paint in the window, or None where there is little or it is too wide for a line."""
    reach_m = math.hypot(p.window_length_m / 2, p.window_half_width_m)
    points = paint.near(float(centre[0]), float(centre[1]), reach_m)
    delta = points - centre
    c, s = math.cos(direction_rad), math.sin(direction_rad)
    along, across = delta @ (c, s), delta @ (-s, c)
    inside = (np.abs(along) < p.window_length_m / 2) & (np.abs(across) < p.window_half_width_m)
    count, across = np.count_nonzero(inside), across[inside]
    if count < p.window_points or across @ across / count - (across.sum() / count) ** 2 > p.line_sd_m**2:
        return None
    middle: Array = points[inside].sum(axis=0) / count
    return middle
