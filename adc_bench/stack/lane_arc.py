"""The driven lane without a map: its middle as an arc, corrected by the lane's lines picture after picture."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.stack.lane_lines import LaneLine, LaneLines
from adc_bench.stack.prediction import arc_step

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class LaneArcParams:
    """How much the lane may bend anew, and which points of its lines are believed.

    `doubt` is what each picture adds to the spread of offset (m), heading (rad) and curvature (1/m).
    """

    doubt: tuple[float, float, float] = (0.01, 0.02, 0.15)
    point_sd_m: float = 0.06  # many points of one picture share its error
    gate_sds: float = 3.0
    gate_m: tuple[float, float] = (0.05, 0.20)
    reach_m: float = 1.6
    apart_m: float = 0.10  # lines whose middles differ by more belong to two roads
    least_points: int = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class LaneArc:
    """The lane's middle: an arc of some curvature (left positive) from a pose on, both in the frame of the odometry.

    `covariance` (3, 3) is that of the pose's offset and heading and of the curvature.
    """

    pose: Pose2
    curvature_pm: float = 0.0
    covariance: Array = field(default_factory=lambda: np.diag(np.square([0.05, 0.05, 0.2])))


def abreast(arc: LaneArc, pose: Pose2) -> LaneArc:
    """Return the same arc from the place beside a pose on."""
    seen, k = arc.pose.inverse() @ pose, arc.curvature_pm
    turn = math.atan2(k * seen.x_m, 1 - k * seen.y_m)
    s_m = turn / k if abs(k) > 1e-6 else seen.x_m
    F = np.array([[1.0, s_m, s_m**2 / 2], [0.0, 1.0, s_m], [0.0, 0.0, 1.0]])
    return replace(arc, pose=arc.pose @ arc_step(s_m, k * s_m), covariance=F @ arc.covariance @ F.T)


def correct(arc: LaneArc, pose: Pose2, lines: LaneLines, half_lane_m: float, params: LaneArcParams) -> LaneArc:
    """Return the arc beside a pose, corrected by the lines that a picture taken there shows.

    Where a road branches off, one line goes with it: of two lines that do not run side by side the left one counts, the
    road's middle, which leads straight on.
    """
    arc = abreast(arc, pose)
    arc = replace(arc, covariance=arc.covariance + np.diag(np.square(params.doubt)))
    sides = {-half_lane_m: lines.right, half_lane_m: lines.left}
    seen = {offset: _compare(arc, pose, line, offset, params) for offset, line in sides.items() if line}
    if len(seen) == 2 and _part(seen[-half_lane_m], seen[half_lane_m], params):
        del seen[-half_lane_m]
    return _corrected(arc, seen.values(), params)


def _compare(arc: LaneArc, pose: Pose2, line: LaneLine, offset_m: float, p: LaneArcParams) -> Array:
    """Return rows (place along the arc, residual) of the line's points, nearest first.

    A residual is how far left of its due place a point lies; what is beyond the reach or the gate is left out.
    """
    a, b = arc.pose.inverse().transform(pose.transform(line.points_robot)).T
    k = arc.curvature_pm
    aside = b - k * (a**2 + b**2) / 2
    residual = 2 * aside / (1 + np.sqrt(np.maximum(1 - 2 * k * aside, 0.0))) - offset_m
    H = _jacobian(a)
    spread = np.sqrt(np.einsum("ni,ij,nj->n", H, arc.covariance, H) + p.point_sd_m**2)
    believed = (np.abs(a) < p.reach_m) & (np.abs(residual) < np.clip(p.gate_sds * spread, *p.gate_m))
    rows: Array = np.column_stack([a, residual])[believed]
    return rows[np.argsort(rows[:, 0], kind="stable")]


def _part(right: Array, left: Array, p: LaneArcParams) -> bool:
    """Return whether the left line is there and the right one leads away from it."""
    if len(left) < p.least_points or not len(right):
        return False
    beside = (right[:, 0] >= left[0, 0]) & (right[:, 0] <= left[-1, 0])
    apart = np.abs(right[:, 1] - np.interp(right[:, 0], left[:, 0], left[:, 1]))
    return bool((apart[beside] > p.apart_m).any())


def _corrected(arc: LaneArc, seen: Iterable[Array], p: LaneArcParams) -> LaneArc:
    information = np.linalg.inv(arc.covariance)
    pull = np.zeros(3)
    for rows in seen:
        if len(rows) >= p.least_points:
            H = _jacobian(rows[:, 0]) / p.point_sd_m
            information = information + H.T @ H
            pull = pull + H.T @ rows[:, 1] / p.point_sd_m
    covariance = np.linalg.inv(information)
    offset_m, heading_rad, curvature_pm = (float(v) for v in covariance @ pull)
    return LaneArc(
        pose=arc.pose @ Pose2(x_m=0.0, y_m=offset_m, yaw_rad=heading_rad),
        curvature_pm=arc.curvature_pm + curvature_pm,
        covariance=(covariance + covariance.T) / 2,
    )


def _jacobian(along_m: Array) -> Array:
    """Return (n, 3): how the arc moves aside, at places along it, with its offset, heading and curvature."""
    return np.column_stack([np.ones_like(along_m), along_m, along_m**2 / 2])
