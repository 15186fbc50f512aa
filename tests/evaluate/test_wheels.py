"""Wheels on lines and off the road, against polygons made by hand from the course's figures."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from adc_bench.evaluate.ground import ground_of as open_road
from adc_bench.evaluate.wheels import SPACING_M, footing, patch_points, poses_between
from adc_bench.geometry import Pose2
from adc_bench.world.course import COURSE_SETS, Course, CourseName, CourseSpec
from adc_bench.world.layout import Layout

Array = NDArray[np.float64]
SEPARATION_M, WHEEL_M = 0.33, 0.05


def arc(x_m: float, radius_m: float, from_deg: float, to_deg: float) -> Array:
    angles = np.radians(np.linspace(from_deg, to_deg, 1001))
    return np.stack([x_m + radius_m * np.cos(angles), radius_m * np.sin(angles)], axis=1)


def mirrored(points: Array) -> Array:
    return points * [-1.0, 1.0]


@dataclass(frozen=True)
class Ground:
    """The road's surface and its painted solid lines as polygons, and the lines' centres."""

    road: shapely.Geometry
    paint: shapely.Geometry
    centres: tuple[Array, ...]


def ground_of(c: CourseSpec) -> Ground:
    loop, s_road, outer, inner = c.loop_centre_x_m, c.s_road_centre_x_m, c.radius_outer_m, c.radius_inner_m
    tip_deg = -math.degrees(math.asin(inner / outer))
    tip = s_road + outer * math.cos(math.radians(tip_deg))
    outline = np.concatenate(
        [
            arc(loop, outer, -90, 180),
            arc(s_road, inner, 0, -90),
            mirrored(arc(s_road, inner, -90, 0)),
            mirrored(arc(loop, outer, 180, -90)),
            [[c.bulge_start_x_m, -outer]],
        ]
    )
    drop = np.concatenate([[[tip, -inner]], arc(loop, inner, -90, 180), arc(s_road, outer, 0, tip_deg)])
    x0, x1, far = c.bulge_start_x_m, loop, -outer - c.bulge_depth_m
    bulge = np.array([[x0, -outer], [x0 + c.bulge_taper_m, far], [x1 - c.bulge_taper_m, far], [x1, -outer]])
    centres = (outline, drop, mirrored(drop), bulge)
    lines = [shapely.LineString(line).buffer(c.edge_line_width_m / 2, quad_segs=16) for line in centres]
    islands = shapely.union_all([shapely.Polygon(drop), shapely.Polygon(mirrored(drop))])
    road = shapely.Polygon(outline).union(shapely.Polygon(bulge)).difference(islands)
    shapely.prepare(road)
    paint = shapely.union_all(lines)
    shapely.prepare(paint)
    return Ground(road, paint, centres)


def poses_near(ground: Ground, rng: np.random.Generator, count: int) -> list[Pose2]:
    """Draw poses whose wheels are within reach of a line, every line alike."""
    poses = []
    for _ in range(count):
        line = shapely.LineString(ground.centres[rng.integers(len(ground.centres))])
        at = line.interpolate(rng.uniform(), normalized=True)
        x_m, y_m = np.array([at.x, at.y]) + rng.uniform(-0.3, 0.3, size=2)
        poses.append(Pose2(x_m=x_m, y_m=y_m, yaw_rad=rng.uniform(-math.pi, math.pi)))
    return poses


def wheels(pose: Pose2) -> list[tuple[shapely.Point, shapely.LineString]]:
    """Return each wheel's contact point, and its patch: a segment across the wheel."""
    made = []
    for left_m in (SEPARATION_M / 2, -SEPARATION_M / 2):
        points = pose.transform([(0.0, left_m + side * WHEEL_M / 2) for side in (-1, 0, 1)])
        made.append((shapely.Point(points[1]), shapely.LineString(points[[0, 2]])))
    return made


@pytest.mark.parametrize("name", ["a", "b"])
def test_a_standing_robot_is_where_the_polygons_have_it(name: CourseName) -> None:
    course, rng = Course(spec=COURSE_SETS[name]), np.random.default_rng(7)
    ground = ground_of(course.spec)
    seen, wrong = np.zeros((3, 2), dtype=int), 0
    for pose in poses_near(ground, rng, 3000):
        found = footing(open_road(course, Layout(), None), pose, pose, SEPARATION_M, WHEEL_M)
        off = [not ground.road.covers(point) for point, _ in wheels(pose)]
        on_line = any(ground.paint.intersects(patch) for _, patch in wheels(pose))
        expected = (on_line, any(off), all(off))
        told = (found.on_line, found.a_wheel_off, found.all_off)
        wrong += told != expected
        seen[range(3), [int(value) for value in expected]] += 1
    assert seen.min() > 300, "every answer occurs often"
    assert wrong <= 6, "the lines' polygons differ by some 1e-5 m"


def test_a_moving_robot_misses_nothing_on_its_way() -> None:
    """Against poses a millimetre apart: what is told happened; what is missed is shorter than the spacing."""
    course, rng = Course(), np.random.default_rng(8)
    ground = ground_of(course.spec)
    wider = ground.paint.buffer(1e-4)
    shapely.prepare(wider)
    told_on_line = missed = 0
    for before in poses_near(ground, rng, 300):
        step = Pose2(x_m=rng.uniform(0.0, 0.11), y_m=0.0, yaw_rad=rng.uniform(-0.1, 0.1))
        now = before @ step
        found = footing(open_road(course, Layout(), None), before, now, SEPARATION_M, WHEEL_M)
        shares = np.linspace(0.0, 1.0, 111)[1:, None]
        way = shares * np.array([now.x_m - before.x_m, now.y_m - before.y_m, step.yaw_rad])
        fine = way + np.array([before.x_m, before.y_m, before.yaw_rad])
        points = patch_points(fine, SEPARATION_M, WHEEL_M)
        patches = shapely.linestrings(points[:, :, [0, 2]])
        on_line = shapely.intersects(ground.paint, patches)
        off = ~shapely.covers(ground.road, shapely.points(points[:, :, 1]))
        assert found.on_line <= shapely.intersects(wider, patches).any()
        assert found.a_wheel_off <= off.any()
        missed += bool(on_line.any()) and not found.on_line
        told_on_line += found.on_line
        if found.on_line != on_line.any():
            longest = max(np.count_nonzero(on_line[:, wheel]) for wheel in (0, 1)) * step.x_m / 110
            assert longest <= SPACING_M
    assert told_on_line > 80 and missed <= 15


def test_the_wheels_stand_beside_the_middle() -> None:
    (left, right), *_ = patch_points(np.array([[1.0, 2.0, math.pi / 2]]), SEPARATION_M, WHEEL_M)
    assert left[1] == pytest.approx((1.0 - SEPARATION_M / 2, 2.0))
    assert right[1] == pytest.approx((1.0 + SEPARATION_M / 2, 2.0))
    assert math.dist(left[0], left[2]) == pytest.approx(WHEEL_M)


@pytest.mark.parametrize("length_m", [0.0, 0.01, 0.1, 0.11])
def test_the_poses_between_end_where_the_robot_is(length_m: float) -> None:
    before = Pose2(x_m=1.0, y_m=-2.0, yaw_rad=3.1)
    now = before @ Pose2(x_m=length_m, y_m=0.0, yaw_rad=0.2)  # turns over +-pi
    poses = poses_between(before, now)
    assert poses[-1, :2] == pytest.approx((now.x_m, now.y_m))
    assert math.cos(poses[-1, 2] - now.yaw_rad) == pytest.approx(1.0)
    gaps = np.hypot(*np.diff(np.vstack([[before.x_m, before.y_m, before.yaw_rad], poses]), axis=0)[:, :2].T)
    assert gaps.max() <= SPACING_M + 1e-12
    assert np.abs(np.diff(poses[:, 2])).max(initial=0.0) < 0.1
