import numpy as np
import pytest
import shapely

from adc_bench.geometry import Pose2
from adc_bench.stack.paint_edges import WIDEST_M, EdgeMapParams, PaintEdges, paint_edges
from adc_bench.world.course import COURSE_SETS, Course, CourseName

PARAMS = EdgeMapParams()


@pytest.fixture(scope="module", params=["a", "b"])
def course(request: pytest.FixtureRequest) -> Course:
    name: CourseName = request.param
    return Course(spec=COURSE_SETS[name])


@pytest.fixture(scope="module")
def edges(course: Course) -> PaintEdges:
    return paint_edges(course)


def in_paint(course: Course, points: np.ndarray) -> np.ndarray:
    paint = shapely.union_all(course.paint)
    shapely.prepare(paint)
    return np.asarray(shapely.contains_xy(paint, points[:, 0], points[:, 1]))


def test_normals_lead_from_paint_to_floor(course: Course, edges: PaintEdges) -> None:
    np.testing.assert_allclose(np.hypot(*edges.normals.T), 1, atol=1e-12)
    assert in_paint(course, edges.points - 2e-3 * edges.normals).all()
    assert not in_paint(course, edges.points + 2e-3 * edges.normals).any()


def test_points_lie_on_the_border_and_clear_of_corners(course: Course, edges: PaintEdges) -> None:
    border = shapely.boundary(shapely.union_all(course.paint))
    assert shapely.distance(border, shapely.points(edges.points)).max() < 2e-6
    crosswalk = course.crosswalk_corners
    away = np.hypot(*(edges.points[:, None] - crosswalk).transpose(2, 0, 1))
    assert away.min() >= PARAMS.corner_margin_m


def test_no_stretch_of_border_is_left_out(course: Course, edges: PaintEdges) -> None:
    border = shapely.boundary(shapely.union_all(course.paint))
    along = shapely.points(shapely.get_coordinates(shapely.segmentize(border, 0.05)))
    far = shapely.distance(along, shapely.multipoints(edges.points))
    # Where two lines run into each other at a sharp angle, short pieces have no place clear of corners.
    assert np.quantile(far, 0.998) < PARAMS.step_m
    assert far.max() < 0.1


def test_widths_are_those_of_the_marks(course: Course, edges: PaintEdges) -> None:
    """Walking back through the paint in steps of 2 mm ends where the width says."""
    some = edges.of(np.arange(len(edges.points)) % 23 == 0)
    steps = np.arange(1e-3, WIDEST_M, 2e-3)
    walked = (some.points[:, None] - steps[:, None] * some.normals[:, None]).reshape(-1, 2)
    inside = in_paint(course, walked).reshape(len(some.points), -1)
    measured = np.logical_and.accumulate(inside, axis=1).sum(axis=1) * 2e-3
    np.testing.assert_allclose(some.widths_m, measured, atol=4e-3)


def test_from_a_pose_they_are_where_the_pose_sees_them(edges: PaintEdges) -> None:
    pose = Pose2(x_m=1.2, y_m=-3.0, yaw_rad=2.1)
    seen = edges.seen_from(pose)
    np.testing.assert_allclose(pose.transform(seen.points), edges.points, atol=1e-12)
    tips = pose.transform(seen.points + seen.normals)
    np.testing.assert_allclose(tips - edges.points, edges.normals, atol=1e-12)
