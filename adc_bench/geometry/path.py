"""Plane curves of constant-curvature pieces (lines and arcs): exact arc length, curvature, offset and projection."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from adc_bench.geometry.pose import Pose2

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A line (curvature 0) or an arc; positive curvature turns left."""

    length_m: float
    curvature_pm: float


@dataclass(frozen=True, kw_only=True)
class Path:
    """A tangent-continuous curve from `start` along `pieces`; `closed` if its end is its start."""

    start: Pose2
    pieces: tuple[Piece, ...]
    closed: bool = False

    @cached_property
    def length_m(self) -> float:
        """The arc length of the whole curve."""
        return math.fsum(piece.length_m for piece in self.pieces)

    @cached_property
    def knots_m(self) -> Array:
        """Arc length at each piece's start and at the end, (n + 1,)."""
        return np.concatenate([[0.0], np.cumsum([piece.length_m for piece in self.pieces])])

    @cached_property
    def _starts(self) -> tuple[Pose2, ...]:
        poses = [self.start]
        for piece in self.pieces:
            poses.append(poses[-1] @ _advance(piece.length_m, piece.curvature_pm))
        return tuple(poses)

    @cached_property
    def _start_figures(self) -> Array:
        """Where each piece starts: x, y in metres and yaw in radians, and the end, (n + 1, 3)."""
        return np.array([(pose.x_m, pose.y_m, pose.yaw_rad) for pose in self._starts])

    @cached_property
    def _curvatures_pm(self) -> Array:
        """Each piece's curvature, (n,)."""
        return np.array([piece.curvature_pm for piece in self.pieces])

    def _piece_at(self, s_m: Array) -> NDArray[np.intp]:
        index = np.searchsorted(self.knots_m, s_m, side="right") - 1
        return np.clip(index, 0, len(self.pieces) - 1)

    def poses(self, s_m: ArrayLike) -> Array:
        """Return (n, 3): x, y in metres and yaw in radians at arc lengths (n,); wrapped round if closed."""
        s = np.atleast_1d(np.asarray(s_m, dtype=np.float64))
        s = np.mod(s, self.length_m) if self.closed else np.clip(s, 0.0, self.length_m)
        index = self._piece_at(s)
        start = self._start_figures[index]
        curvature = self._curvatures_pm[index]
        along = s - self.knots_m[index]
        turn = curvature * along
        half = turn / 2
        chord = along * np.sinc(half / np.pi)
        yaw = start[:, 2] + half
        return np.stack(
            [start[:, 0] + chord * np.cos(yaw), start[:, 1] + chord * np.sin(yaw), start[:, 2] + turn], axis=1
        )

    def pose(self, s_m: float) -> Pose2:
        """Return the pose on the curve at one arc length."""
        x_m, y_m, yaw_rad = self.poses(s_m)[0]
        return Pose2(x_m=float(x_m), y_m=float(y_m), yaw_rad=float(yaw_rad))

    def curvature_pm(self, s_m: ArrayLike) -> Array:
        """Return the signed curvature (n,) in 1/m at arc lengths (n,)."""
        s = np.atleast_1d(np.asarray(s_m, dtype=np.float64))
        s = np.mod(s, self.length_m) if self.closed else s
        return self._curvatures_pm[self._piece_at(s)]

    def sample(self, step_m: float) -> Array:
        """Return poses (n, 3) no farther apart than `step_m`, every knot among them."""
        spans = [
            a + (b - a) * np.arange(math.ceil(max((b - a) / step_m, 1))) / math.ceil(max((b - a) / step_m, 1))
            for a, b in zip(self.knots_m[:-1], self.knots_m[1:], strict=True)
        ]
        s = np.concatenate([*spans, [self.length_m]])
        return self.poses(np.minimum(s, self.length_m * (1 - 1e-15)) if self.closed else s)

    def project(
        self, points: ArrayLike, *, around_s_m: float | None = None, window_m: float = 1.5
    ) -> tuple[Array, Array]:
        """Return (s_m, offset_m), each (n,): arc length of the nearest point and signed distance, left positive.

        With `around_s_m` only the stretch within `window_m` of it counts, so that a curve that crosses itself
        keeps its branch; on a closed curve the stretch may pass the end.
        """
        points = np.atleast_2d(np.asarray(points, dtype=np.float64))
        best = np.full(len(points), np.inf)
        best_s, best_offset = np.zeros(len(points)), np.zeros(len(points))
        for index, (low, high) in self._stretches(around_s_m, window_m):
            s, offset, distance = self._project_piece(index, low, high, points)
            nearer = distance < best - 1e-12
            best = np.where(nearer, distance, best)
            best_s, best_offset = np.where(nearer, s, best_s), np.where(nearer, offset, best_offset)
        return best_s, best_offset

    def _stretches(self, around_s_m: float | None, window_m: float) -> Sequence[tuple[int, tuple[float, float]]]:
        """Return (piece, (from, to)) in metres along each piece, for the pieces that the window meets."""
        whole = [(i, (0.0, piece.length_m)) for i, piece in enumerate(self.pieces)]
        if around_s_m is None or 2 * window_m >= self.length_m:
            return whole
        centre = around_s_m % self.length_m if self.closed else around_s_m
        shifts = (-self.length_m, 0.0, self.length_m) if self.closed else (0.0,)
        found = []
        for i, (_, (_, length)) in enumerate(whole):
            for shift in shifts:
                low = max(centre - window_m + shift - self.knots_m[i], 0.0)
                high = min(centre + window_m + shift - self.knots_m[i], length)
                if low < high:
                    found.append((i, (low, high)))
        return found

    def _project_piece(self, index: int, low: float, high: float, points: Array) -> tuple[Array, Array, Array]:
        start, curvature = self._starts[index], self.pieces[index].curvature_pm
        local = start.inverse().transform(points)
        if curvature == 0.0:
            along = local[:, 0]
        else:
            angle = np.arctan2(local[:, 0], 1 / abs(curvature) - local[:, 1] * np.sign(curvature))
            middle = (low + high) / 2 * abs(curvature)
            angle = middle + (angle - middle + np.pi) % (2 * np.pi) - np.pi
            along = angle / abs(curvature)
        along = np.clip(along, low, high)
        s = self.knots_m[index] + along
        foot = self.poses(s) if not self.closed else self.poses(np.minimum(s, self.length_m * (1 - 1e-15)))
        delta = points - foot[:, :2]
        side = np.cos(foot[:, 2]) * delta[:, 1] - np.sin(foot[:, 2]) * delta[:, 0]
        distance = np.hypot(delta[:, 0], delta[:, 1])
        return s, np.copysign(distance, side), distance

    def offset(self, left_m: float) -> "Path":
        """Return the parallel curve `left_m` to the left (negative: right); its radii must stay positive."""
        pieces = []
        for piece in self.pieces:
            scale = 1 - piece.curvature_pm * left_m
            assert scale > 0, "the parallel curve would fold over"
            pieces.append(Piece(length_m=piece.length_m * scale, curvature_pm=piece.curvature_pm / scale))
        return Path(
            start=self.start @ Pose2(x_m=0.0, y_m=left_m, yaw_rad=0.0),
            pieces=tuple(pieces),
            closed=self.closed,
        )


def line(length_m: float) -> Piece:
    """Return a straight piece."""
    return Piece(length_m=length_m, curvature_pm=0.0)


def arc(radius_m: float, turn_rad: float) -> Piece:
    """Return an arc that turns by `turn_rad`, left positive."""
    return Piece(length_m=radius_m * abs(turn_rad), curvature_pm=math.copysign(1 / radius_m, turn_rad))


def _advance(length_m: float, curvature_pm: float) -> Pose2:
    turn = length_m * curvature_pm
    chord = length_m * float(np.sinc(turn / 2 / np.pi))
    return Pose2(x_m=chord * math.cos(turn / 2), y_m=chord * math.sin(turn / 2), yaw_rad=turn)
