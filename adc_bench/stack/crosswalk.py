"""The crosswalk landmark: the detector says where, the bird's-eye picture says exactly where.

The box gives a first place on the floor; the known pattern of stop lines and stripes is then laid over the paint and
moved until it fits.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.crosswalk_box import place_of_box
from adc_bench.stack.crosswalk_pattern import CrosswalkPattern
from adc_bench.stack.paint import Paint
from adc_bench.stack.robust_fit import FitNoise, point_sd_m
from adc_bench.world.course import CourseSpec
from adc_bench.world.frame import BoxPx

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class CrosswalkParams:
    """How the pattern is searched for and when it is believed."""

    margin_m: float = 0.05  # floor round the pattern that must be bare; the edge lines begin beyond it
    step_m: float = 0.02
    search_along_m: float = 0.16
    search_across_m: float = 0.08  # less than half the stripes' pitch, beyond which the pattern repeats
    search_step_m: float = 0.04
    search_rad: float = 0.08
    rival_share: float = 0.85  # of a rival's unexplained part, at most
    least_correlation: float = 0.8
    least_seen: float = 0.5
    farthest_m: float = 2.8  # of its middle
    blur_cells: int = 5
    fit_sd_m: float = 0.008


@dataclass(frozen=True, kw_only=True, eq=False)
class SeenCrosswalk:
    """The near stop line's outer corners, right then left, (2, 2) in the robot frame; their covariances (2, 2, 2)."""

    pose_robot_crosswalk: Pose2
    corners_robot: Array
    covariances: Array
    correlation: float


@dataclass(frozen=True, kw_only=True)
class CrosswalkFinder:
    """The pattern of the map's crosswalk and how to find it under a camera."""

    spec: CourseSpec
    birds_eye: BirdsEye
    params: CrosswalkParams = field(default_factory=CrosswalkParams)
    noise: FitNoise = field(default_factory=FitNoise)

    @cached_property
    def _shape(self) -> CrosswalkPattern:
        return CrosswalkPattern(spec=self.spec)

    @cached_property
    def _pattern(self) -> tuple[Array, Array]:
        """Points (n, 2) of the pattern's frame and what the blurred paint shows there, 0 to 1 (n,)."""
        p = self.params
        points = self._shape.grid(p.step_m, p.margin_m)
        return points, self._shape.blurred(points, p.blur_cells * self.birds_eye.region.cell_m)

    def find(self, box_px: BoxPx, road_yaw_rad: float, paint: Paint) -> SeenCrosswalk | None:
        """Return the crosswalk behind a detector's box, or None where it is far, cut off or fits in two places.

        `road_yaw_rad` is the road's direction in the robot frame, known to a few degrees.
        """
        first = place_of_box(box_px, road_yaw_rad, self._shape, self.birds_eye)
        if first is None or math.hypot(first.x_m, first.y_m) > self.params.farthest_m:
            return None
        size = self.params.blur_cells - 2
        soft = np.asarray(cv2.blur(np.maximum(paint.contrast, np.float32(0)), (size, size)), dtype=np.float32)
        fitted = self._fit(self._search(first, soft), soft)
        if fitted is None or abs((first.inverse() @ fitted[0]).y_m) > self.spec.stripe_pitch_m / 2:
            return None
        pose, correlation = fitted
        corners = pose.transform(self._shape.corners[:2])
        return SeenCrosswalk(
            pose_robot_crosswalk=pose,
            corners_robot=corners,
            covariances=self._covariances(corners),
            correlation=correlation,
        )

    def _fit(self, coarse: Pose2, soft: NDArray[np.float32]) -> tuple[Pose2, float] | None:
        """Return the best pose with its correlation, or None where it is low or one stripe aside fits about as well."""
        p, pitch_m = self.params, self.spec.stripe_pitch_m
        starts = (_moved(coarse, np.array([0.0, pitch_m * k, 0.0])) for k in (-1, 0, 1))
        rival, best = sorted((self._refine(start, soft) for start in starts), key=lambda fit: fit[1])[1:]
        apart_m = math.hypot(best[0].x_m - rival[0].x_m, best[0].y_m - rival[0].y_m)
        doubtful = apart_m > pitch_m / 2 and 1 - best[1] > p.rival_share * (1 - rival[1])
        return None if doubtful or best[1] < p.least_correlation else best

    def _sample(self, soft: NDArray[np.float32], points_robot: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return the picture's values at floor points (..., n, 2), and which of them were seen, (..., n) each."""
        shape = points_robot.shape[:-1]
        cells = self.birds_eye.region.cells(points_robot.reshape(-1, 2)).astype(np.float32)
        # OpenCV's pictures have at most 32767 columns: points lie in rows of one pose each.
        columns, rows = (np.ascontiguousarray(cells[:, k]).reshape(-1, shape[-1]) for k in (0, 1))
        values = cv2.remap(soft, columns, rows, cv2.INTER_LINEAR, borderValue=0)
        seen = cv2.remap(self._inner, columns, rows, cv2.INTER_NEAREST, borderValue=0)
        return np.asarray(values, dtype=np.float64).reshape(shape), np.asarray(seen > 0).reshape(shape)

    @cached_property
    def _inner(self) -> NDArray[np.uint8]:
        size = 2 * self.params.blur_cells + 1
        return np.asarray(cv2.erode(self.birds_eye.seen.astype(np.uint8), np.ones((size, size), np.uint8)), np.uint8)

    def _search(self, first: Pose2, soft: NDArray[np.float32]) -> Pose2:
        """Return the best place on a grid about the first one."""
        p = self.params
        along = np.arange(-p.search_along_m, p.search_along_m + 1e-9, p.search_step_m)
        across = np.arange(-p.search_across_m, p.search_across_m + 1e-9, p.search_step_m)
        grids = np.meshgrid(along, across, (-p.search_rad, 0.0, p.search_rad), indexing="ij")
        shifts = np.stack([grid.ravel() for grid in grids], axis=1)
        points, pattern = self._coarse_pattern
        moved = [_moved(first, shift) for shift in shifts]
        values, seen = self._sample(soft, np.stack([pose.transform(points) for pose in moved]))
        scores = _correlations(values, pattern, seen, p.least_seen)
        return moved[int(np.argmax(scores))]

    @cached_property
    def _coarse_pattern(self) -> tuple[Array, Array]:
        points, pattern = self._pattern
        return points[::9], pattern[::9]

    def _refine(self, coarse: Pose2, soft: NDArray[np.float32]) -> tuple[Pose2, float]:
        """Return the pose of least squared difference between picture and pattern (Gauss-Newton, free gain and offset)
        and its correlation, 0 where too little of it is seen.
        """
        points, pattern = (part[::2] for part in self._pattern)
        pose, step = coarse, self.params.step_m / 2
        for _ in range(6):
            values, seen = self._sample(soft, pose.transform(points))
            columns = [pattern, np.ones_like(pattern)]
            for shift in np.diag([step, step, step]):
                ahead, ok_ahead = self._sample(soft, _moved(pose, shift).transform(points))
                behind, ok_behind = self._sample(soft, _moved(pose, -shift).transform(points))
                seen = seen & ok_ahead & ok_behind
                columns.append((behind - ahead) / (2 * step))
            design = np.stack(columns, axis=1)[seen]
            if len(design) < self.params.least_seen * len(points):
                return pose, 0.0
            solution = np.linalg.lstsq(design, values[seen], rcond=None)[0]
            pose = _moved(pose, np.clip(solution[2:], -0.03, 0.03))
        values, seen = self._sample(soft, pose.transform(points))
        return pose, float(_correlations(values[None], pattern, seen[None], self.params.least_seen)[0])

    def _covariances(self, corners: Array) -> Array:
        """Return (2, 2, 2): the fit's own spread, and what an unknown camera tilt would shift."""
        by_tilt = self.birds_eye.tilt_jacobian(corners) * self.noise.tilt_sd_rad
        spread = np.hypot(point_sd_m(corners, self.birds_eye, self.noise) / 2, self.params.fit_sd_m)
        covariances: Array = by_tilt @ by_tilt.transpose(0, 2, 1) + np.eye(2) * spread[:, None, None] ** 2
        return covariances


def _moved(pose: Pose2, shift: Array) -> Pose2:
    """Return the pose shifted by (dx, dy, turn) in its own frame."""
    return pose @ Pose2(x_m=float(shift[0]), y_m=float(shift[1]), yaw_rad=float(shift[2]))


def _correlations(values: Array, pattern: Array, seen: NDArray[np.bool_], least_seen: float) -> Array:
    """Return (m,) correlations of pictures (m, n) with the pattern (n,) over what is seen; 0 where that is little."""
    count = np.maximum(seen.sum(axis=1), 1)
    a = np.where(seen, values - ((values * seen).sum(axis=1) / count)[:, None], 0.0)
    b = np.where(seen, pattern - ((pattern * seen).sum(axis=1) / count)[:, None], 0.0)
    scale = np.sqrt((a * a).sum(axis=1) * (b * b).sum(axis=1))
    enough = (seen.mean(axis=1) >= least_seen) & (scale > 0)
    correlations: Array = np.where(enough, (a * b).sum(axis=1) / np.where(enough, scale, 1.0), 0.0)
    return correlations
