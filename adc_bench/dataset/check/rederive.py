"""Labels derived again from the scenario and the camera's pose, and compared with those in the shard."""

from collections.abc import Iterator, Mapping

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.dataset.check.fault import Fault
from adc_bench.dataset.check.projection import Shape, View, shapes_of
from adc_bench.dataset.shard import Shard
from adc_bench.geometry import Pose3
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.course import Course
from adc_bench.world.frame import KEYPOINT_OUTSIDE, Label, LaneLine

Array = NDArray[np.float64]
TOLERANCE_PX = 1.0
LANE_LINE_PX = 0.5
LANE_LINE_M = 0.02
PLACE_M = 1e-3


class Rederivation:
    """Derives the labels of frames of one shard; knows how many it could derive and compare."""

    def __init__(self, shard: Shard, *, moving: bool) -> None:
        self._shard, self._moving = shard, moving
        self._shapes: dict[str, Mapping[str, Shape]] = {}
        self.compared = 0

    def faults(self, row: int) -> Iterator[Fault]:
        """Yield what differs in a frame: boxes, keypoints, places of what does not move, lane lines."""
        name = self._shard.conditions(row).scenario
        scenario = self._shard.scenarios[name]
        if name not in self._shapes:
            self._shapes[name] = shapes_of(scenario)
        view = View(scenario.rig.camera(self._shard.cameras[row]), self._shard.pose_world_camera[row])
        for label in self._shard.labels(row):
            for text in self._label_faults(label, self._shapes[name], view):
                yield Fault(row, f"{label.instance}: {text}")
        for line in self._shard.lane_lines(row):
            for text in _lane_line_faults(line, scenario.course, view):
                yield Fault(row, f"lane line {line.name}: {text}")

    def _label_faults(self, label: Label, shapes: Mapping[str, Shape], view: View) -> Iterator[str]:
        shape = shapes.get(label.instance)
        if shape is None:
            yield "no such thing in its scenario"
            return
        pose = Pose3.from_figures(label.pose_world_object)
        if not self._moves(label) and not _same_place(pose, shape.pose_world):
            yield "it is not where its scenario puts it"
        outline = view.outline([pose.transform(piece) for piece in shape.pieces])
        if outline is None or outline.is_empty:
            return
        self.compared += 1
        yield from _box_faults(label, outline, view)
        if shape.keypoints is not None:
            yield from _keypoint_faults(label, view.project(pose.transform(shape.keypoints)), view)

    def _moves(self, label: Label) -> bool:
        return self._moving and CATEGORIES[label.category_id - 1] in ("box", "cone")


def _same_place(pose: Pose3, wanted: Pose3) -> bool:
    return bool(np.allclose(pose.matrix(), wanted.matrix(), atol=PLACE_M))


def _box_faults(label: Label, outline: shapely.Geometry, view: View) -> Iterator[str]:
    width, height = view.size_px
    clipped = shapely.intersection(outline, shapely.box(0, 0, width, height))
    if not clipped.is_empty and (off := _off(label.amodal_box_px, clipped.bounds)) > TOLERANCE_PX:
        yield f"its amodal box is {off:.1f} px off its projection"
    within = shapely.box(-width, -height, 2 * width, 2 * height).contains(outline)
    if within and (off := _off(label.amodal_box_whole_px, outline.bounds)) > TOLERANCE_PX:
        yield f"its whole amodal box is {off:.1f} px off its projection"


def _keypoint_faults(label: Label, pixels: Array, view: View) -> Iterator[str]:
    for k, (pixel, (u, v, seen)) in enumerate(zip(pixels, label.keypoints_px, strict=True)):
        if seen != KEYPOINT_OUTSIDE and (off := _off((u, v), pixel)) > TOLERANCE_PX:
            yield f"keypoint {k} is {off:.1f} px off its projection"
        elif seen == KEYPOINT_OUTSIDE and ((pixel > 1) & (pixel < view.size_px - 1)).all():
            yield f"keypoint {k} lies inside the picture and is said to be outside"


def _lane_line_faults(line: LaneLine, course: Course, view: View) -> Iterator[str]:
    points = np.column_stack([line.points_world.astype(np.float64), np.zeros(len(line.points_world))])
    if not len(points):
        return
    if view.depth_m(points).min() <= 0:
        yield "a point lies behind the camera"
        return
    if (off := _off(line.points_px, view.project(points))) > LANE_LINE_PX:
        yield f"a point is {off:.1f} px off its projection"
    if ((line.points_px < -LANE_LINE_PX) | (line.points_px > view.size_px + LANE_LINE_PX)).any():
        yield "a point leaves the picture"
    path = _lane_line_path(course, line.name)
    if path is None:
        yield "no such line on the course"
    elif (off_m := float(shapely.distance(path, shapely.points(points[:, :2])).max())) > LANE_LINE_M:
        yield f"a point lies {off_m:.3f} m beside the line"


def _lane_line_path(course: Course, name: str) -> shapely.LineString | None:
    dashed = dict(zip(("centre_east", "centre_west", "bulge_dashes"), course.dashed_lines, strict=True))
    if name in dashed:
        return shapely.LineString(dashed[name].sample(0.02)[:, :2])
    return shapely.LineString(course.edge_lines[name]) if name in course.edge_lines else None


def _off(found: object, wanted: object) -> float:
    return float(np.abs(np.asarray(found, dtype=np.float64) - np.asarray(wanted, dtype=np.float64)).max())
