"""The course's painted lines in a picture: stretches of their middles that lie in it, and what of them is seen."""

import itertools
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render.other_ids import OtherId
from adc_bench.render.targets import CROSSWALK_ID
from adc_bench.world.course import Course
from adc_bench.world.frame import LaneLine

Array = NDArray[np.float64]
RANGE_M = 6.0  # on the floor, from below the camera; a line 5 cm wide is then some 2 px wide at 320 x 240
STEP_M = 0.1  # between two points of a line, at most
END_STEPS = 32  # of a step, in which a stretch's end is found
DENSE_M = 0.02  # between the points that curves are first drawn through
DASHED = ("centre_east", "centre_west", "bulge_dashes")
_SHARES = np.arange(1, END_STEPS) / END_STEPS
_IS_FLOOR = np.isin(np.arange(256), (OtherId.FLOOR, CROSSWALK_ID))


@dataclass(frozen=True, kw_only=True, eq=False)
class CourseLines:
    """The middles of all painted lines of a course: points (n, 2) on the floor, and which line each belongs to (n,)."""

    names: tuple[str, ...]
    points_world: Array
    line: NDArray[np.int64]


@lru_cache(maxsize=8)
def course_lines(course: Course) -> CourseLines:
    """Return the course's lines, a point at least every `STEP_M`; dashed lines with their gaps."""
    dashes = {name: path.sample(DENSE_M)[:, :2] for name, path in zip(DASHED, course.dashed_lines, strict=True)}
    lines = {name: _every_step(points) for name, points in {**course.edge_lines, **dashes}.items()}
    counts = [len(points) for points in lines.values()]
    return CourseLines(
        names=tuple(lines),
        points_world=np.concatenate(list(lines.values())),
        line=np.repeat(np.arange(len(lines)), counts),
    )


def _every_step(points: Array) -> Array:
    """Return points (n, 2) along a polyline, its ends and the corners of its long sides among them."""
    sides_m = np.hypot(*np.diff(points, axis=0).T)
    along_m = np.concatenate([[0.0], np.cumsum(sides_m)])
    even_m = np.linspace(0.0, along_m[-1], int(np.ceil(along_m[-1] / STEP_M)) + 1)
    corners_m = along_m[1:-1][np.minimum(sides_m[1:], sides_m[:-1]) > STEP_M]
    stations_m = np.union1d(even_m, corners_m)
    return np.column_stack([np.interp(stations_m, along_m, axis) for axis in points.T])


def lane_lines_of(
    ids: NDArray[np.uint8], course: Course, camera: Camera, pose_world_camera: Pose3
) -> tuple[LaneLine, ...]:
    """Return the stretches of lines in the picture and within `RANGE_M` that have a point with nothing before it.

    `ids` (h, w) holds the label ids of the delivered picture. A point is visible where they show the floor.
    """
    lines, look = course_lines(course), _Look.of(camera, pose_world_camera)
    found = _stretches(lines, look)
    if not found:
        return ()
    points_world = np.concatenate([points for _, points in found])
    points_px = look.pixels(points_world)
    # a stretch's end may be rounded onto the picture's border
    columns, rows = np.minimum(points_px.astype(np.int64), (camera.width_px - 1, camera.height_px - 1)).T
    visible = _IS_FLOOR[ids[rows, columns]]
    pixels, places = points_px.astype(np.float32), points_world.astype(np.float32)
    lasts = itertools.accumulate(len(points) for _, points in found)
    each = [(name, slice(last - len(points), last)) for (name, points), last in zip(found, lasts, strict=True)]
    return tuple(
        LaneLine(name=name, points_px=pixels[part], points_world=places[part], visible=visible[part])
        for name, part in each
        if visible[part].any()
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Look:
    """A camera, the world seen from it, and where on the floor (2,) it is."""

    camera: Camera
    pose_camera_world: Pose3
    eye_world: Array

    @classmethod
    def of(cls, camera: Camera, pose: Pose3) -> "_Look":
        return cls(camera=camera, pose_camera_world=pose.inverse(), eye_world=pose.translation_m[:2])

    def pixels(self, points_world: Array) -> Array:
        """Return the pixels (n, 2) of points (n, 2) on the floor."""
        return self.camera.project(self._points_camera(points_world))

    def shows(self, points_world: Array) -> NDArray[np.bool_]:
        """Return which points (n, 2) on the floor lie in the picture and in range."""
        points, away = self._points_camera(points_world), points_world - self.eye_world
        shown: NDArray[np.bool_] = (points[:, 2] > 0) & (away[:, 0] ** 2 + away[:, 1] ** 2 <= RANGE_M**2)
        pixels = self.camera.project(points[shown])
        shown[shown] = ((pixels >= 0) & (pixels < (self.camera.width_px, self.camera.height_px))).all(axis=1)
        return shown

    def _points_camera(self, points_world: Array) -> Array:
        pose = self.pose_camera_world
        points: Array = points_world @ pose.rotation[:, :2].T + pose.translation_m
        return points


def _stretches(lines: CourseLines, look: _Look) -> list[tuple[str, Array]]:
    """Return each stretch's line and points (n, 2) on the floor, led on to where the line leaves picture or range."""
    inside = look.shows(lines.points_world)
    joined = inside[1:] & inside[:-1] & (lines.line[1:] == lines.line[:-1])
    first = np.flatnonzero(inside & ~np.concatenate([[False], joined]))
    last = np.flatnonzero(inside & ~np.concatenate([joined, [False]]))
    ends = _led_on(lines, np.concatenate([first, last]), np.concatenate([first - 1, last + 1]), look)
    found = []
    for a, b, lead, tail in zip(first, last, ends[: len(first)], ends[len(first) :], strict=True):
        points = np.concatenate([lead, lines.points_world[a : b + 1], tail])
        if len(points) > 1:
            found.append((lines.names[lines.line[a]], points))
    return found


def _led_on(lines: CourseLines, inner: NDArray[np.int64], outer: NDArray[np.int64], look: _Look) -> list[Array]:
    """Return for points inside, given their neighbours outside, the last point (1, 2) or none (0, 2) between them."""
    outer = outer.clip(0, len(lines.line) - 1)
    outer = np.where(lines.line[outer] == lines.line[inner], outer, inner)  # a line's own end is led on to itself
    start, end = lines.points_world[inner], lines.points_world[outer]
    between = start[:, None] + _SHARES[:, None] * (end - start)[:, None]
    shown = look.shows(between.reshape(-1, 2)).reshape(between.shape[:2])
    count = np.where(outer == inner, 0, np.logical_and.accumulate(shown, axis=1).sum(axis=1))
    return [points[max(n - 1, 0) : n] for points, n in zip(between, count.tolist(), strict=True)]
