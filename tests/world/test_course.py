"""The course against the published figures of both sets and against itself."""

import math

import numpy as np
import pytest
import shapely

from adc_bench.world.course import COURSE_SETS, Course

COURSE = Course()
BOTH = pytest.mark.parametrize("course", [Course(spec=spec) for spec in COURSE_SETS.values()], ids=list(COURSE_SETS))


def test_a_lap_in_the_right_lane_is_40_46_m_and_closes() -> None:
    assert COURSE.lap.length_m == pytest.approx(40.46, abs=1e-3)
    assert COURSE.lap.length_m == pytest.approx(2 * math.pi * 4.45 + 12.5)
    end = COURSE.lap.poses(COURSE.lap.length_m - 1e-9)[0]
    assert np.allclose(end[:2], [0.0, -2.6125], atol=1e-6)
    assert math.isclose(math.cos(end[2]), 1.0, abs_tol=1e-9)


def test_set_b_has_the_published_figures() -> None:
    b = COURSE_SETS["b"]
    assert (b.radius_outer_m, b.radius_centre_m, b.radius_inner_m) == (3.15, 2.35, 1.55)
    assert (b.loop_centre_x_m, b.s_road_centre_x_m, b.edge_line_width_m) == (5.30, 0.60, 0.10)
    assert b.crosswalk_depth_m == pytest.approx(0.60)
    assert b.radius_outer_m - b.radius_inner_m - b.edge_line_width_m == pytest.approx(1.50)  # clear, as in REF
    lap = Course(spec=b).lap.length_m
    assert lap == pytest.approx(2 * math.pi * (2.75 + 1.95) + 4 * 5.30 - 4 * 2.35, abs=1e-3)


def test_set_a_has_the_published_figures() -> None:
    a = COURSE_SETS["a"]
    assert (a.radius_outer_m, a.radius_centre_m, a.radius_inner_m) == (3.00, 2.225, 1.45)
    assert (a.loop_centre_x_m, a.s_road_centre_x_m, a.edge_line_width_m) == (5.35, 0.90, 0.05)
    assert a.crosswalk_depth_m == pytest.approx(0.70)
    assert a.bulge_depth_m == 0.85


@BOTH
def test_every_line_is_closed_where_it_should_be_and_tangent_all_along(course: Course) -> None:
    for path in (course.lap, course.lanes["left"], course.outer_edge, *course.dashed_lines, *course.drops):
        poses = path.sample(0.001)
        headings = np.unwrap(poses[:, 2])
        assert np.abs(np.diff(headings)).max() < 0.001 * 1.2 / course.spec.radius_inner_m  # no corner
        steps = np.diff(poses[:, :2], axis=0)
        travelled = np.arctan2(steps[:, 1], steps[:, 0])
        turned = np.angle(np.exp(1j * (travelled - (headings[:-1] + headings[1:]) / 2)))
        assert np.abs(turned[np.hypot(*steps.T) > 1e-6]).max() < 1e-3  # and it goes where it points
    for path in (course.lap, course.lanes["left"], course.outer_edge):
        start, end = path.poses([0.0, path.length_m - 1e-9])
        assert np.allclose(start[:2], end[:2], atol=1e-6)
        assert math.cos(start[2] - end[2]) == pytest.approx(1.0)
    for drop in course.drops:  # closed at its tip, where two lines cross
        ends = drop.poses([0.0, drop.length_m])
        assert np.allclose(ends[0, :2], ends[1, :2], atol=1e-9)


@BOTH
def test_each_loop_is_round(course: Course) -> None:
    spec = course.spec
    points = np.concatenate([course.edge_lines[name] for name in ("outer", "drop_east", "drop_west")])
    for side in (1.0, -1.0):
        far = points[side * points[:, 0] > spec.loop_centre_x_m]
        radius = np.hypot(far[:, 0] - side * spec.loop_centre_x_m, far[:, 1])
        to_line = np.minimum(abs(radius - spec.radius_outer_m), abs(radius - spec.radius_inner_m))
        assert to_line.max() < 1e-3


@BOTH
def test_the_parallel_bay_has_its_published_measures(course: Course) -> None:
    spec, place = course.spec, course.parking_places[0]
    (x0, y0), (x1, y1), (x2, _), (x3, _) = course.bulge_corners
    assert (x3 - x0, x2 - x1, y0 - y1) == pytest.approx((5.0, 3.0, 0.85))
    assert x3 == spec.loop_centre_x_m and 0.26 <= x0 <= 0.36
    assert (place.name, place.length_m, place.width_m) == ("parallel", pytest.approx(3.0), 0.85)
    assert shapely.Polygon(course.bulge_corners).contains(shapely.Point(place.pose.x_m, place.pose.y_m))


@BOTH
def test_the_two_place_bay_is_painted_beside_the_road_and_is_none_of_its_lines(course: Course) -> None:
    near, far = course.parking_places[1:]
    middle = shapely.Point((near.pose.x_m + far.pose.x_m) / 2, near.pose.y_m)
    bay = [mark for mark in course.paint if mark.distance(middle) < 0.6]
    x0, y0, x1, y1 = shapely.total_bounds(bay)
    assert (x1 - x0, y1 - y0) == pytest.approx((1.60, 1.05))
    assert -y1 - course.spec.radius_outer_m - course.spec.edge_line_width_m / 2 == pytest.approx(0.25)
    assert x1 == pytest.approx(-1.46)
    assert shapely.MultiLineString(list(course.edge_lines.values())).distance(shapely.box(x0, y0, x1, y1)) > 0.25
    for place in (near, far):
        assert (place.length_m, place.width_m) == pytest.approx((0.95, 0.725))
        half = np.array([place.length_m, place.width_m]) / 2 - 1e-6
        inside = shapely.Polygon(place.pose.transform(half * [(1, 1), (-1, 1), (-1, -1), (1, -1)]))
        letters = [mark for mark in bay if inside.contains(mark)]
        assert len(letters) == 1  # the P
        assert not any(mark.intersects(inside) for mark in bay if mark not in letters)


@BOTH
def test_a_p_reads_from_the_road(course: Course) -> None:
    """Seen by who stands on the road: a stem at the left, a bowl at the top right, nothing at the bottom right."""
    paint = shapely.union_all(course.paint)
    spec = course.spec.bay
    h, w = 0.45 * spec.letter_height_m, 0.45 * spec.letter_width_m
    for place in course.parking_places[1:]:
        on = place.pose.transform([(h, w), (-h, w), (0.0, w), (h, 0.0), (h / 2, -w)])
        off = place.pose.transform([(-h, -w), (-h / 2, -w / 2), (h / 2, w / 3)])
        assert shapely.contains_xy(paint, on).all() and not shapely.contains_xy(paint, off).any()


@BOTH
def test_the_lap_is_driven_in_the_published_lanes_and_senses(course: Course) -> None:
    spec = course.spec
    outer, inner = course.spec.lane_outer_radius_m, course.spec.lane_inner_radius_m
    knots = course.lap.knots_m
    east, west = course.lap.poses((knots[1] + knots[2]) / 2)[0], course.lap.poses((knots[4] + knots[5]) / 2)[0]
    assert math.hypot(east[0] - spec.loop_centre_x_m, east[1]) == pytest.approx(outer)
    assert math.hypot(west[0] + spec.loop_centre_x_m, west[1]) == pytest.approx(inner)
    assert (
        course.lap.curvature_pm((knots[1] + knots[2]) / 2)[0]
        > 0
        > course.lap.curvature_pm((knots[4] + knots[5]) / 2)[0]
    )


def test_line_centres_span_the_published_box() -> None:
    edges = shapely.MultiLineString(list(COURSE.edge_lines.values()))
    x0, y0, x1, y1 = edges.bounds
    assert (x1 - x0, y1 - y0) == pytest.approx((16.70, 6.85), abs=2e-4)
    assert y0 == pytest.approx(-3.85)


@BOTH
def test_tangency_closes_the_course(course: Course) -> None:
    c = course.spec
    assert c.loop_centre_x_m - c.s_road_centre_x_m == pytest.approx(2 * c.radius_centre_m)


def test_the_lane_runs_between_its_lines_everywhere() -> None:
    poses = COURSE.lap.sample(0.05)
    assert COURSE.on_road(poses[:, :2]).all()
    clear = COURSE.distance_to_edge_lines_m(poses[:, :2])
    assert clear.min() == pytest.approx(0.3875, abs=1e-3)
    left = COURSE.lanes["left"].sample(0.05)
    assert COURSE.on_road(left[:, :2]).all()


def test_islands_and_hall_are_off_the_road() -> None:
    outside = [(5.35, 0.0), (-5.35, 0.0), (0.0, 0.0), (0.0, -3.5), (9.0, 0.0)]
    assert not COURSE.on_road(np.array(outside)).any()
    assert COURSE.on_road(np.array([(2.85, -3.4)])).all()  # the parallel bay belongs to the road


def test_paint_is_where_the_figures_put_it() -> None:
    paint = shapely.union_all(COURSE.paint)
    on = [(0.0, -2.225), (-0.3, -1.6), (0.3, -2.85), (-4.0, -3.0), (5.35, 3.0), (0.0, -1.45), (2.0, -3.85)]
    off = [(0.0, -2.125), (-0.21, -2.3), (0.5, -2.6), (5.35, 0.0), (0.0, -3.2)]
    assert shapely.contains_xy(paint, *np.array(on).T).all()
    assert not shapely.contains_xy(paint, *np.array(off).T).any()


def test_line_widths_come_from_the_painted_area() -> None:
    for name, points in COURSE.edge_lines.items():
        length = shapely.LineString(points).length
        widths = [p.area / length for p in COURSE.paint if p.area > 0.15 and abs(p.area / length - 0.05) < 0.004]
        assert widths, name


def test_dashes_have_their_length_and_keep_clear_of_crosswalk_and_mouth() -> None:
    dashes = [p for p in COURSE.paint if 0.008 < p.area < 0.0102]
    assert 105 < len(dashes) < 125
    crosswalk = shapely.Polygon(COURSE.crosswalk_corners)
    assert min(d.distance(crosswalk) for d in dashes) == pytest.approx(COURSE.spec.dash_gap_at_crosswalk_m, abs=1e-3)
    straight = shapely.LineString([(-5.35, -2.225), (5.35, -2.225)])
    s_road = [d for d in dashes if 0.02 < d.distance(straight) < 1.0 and abs(d.centroid.x) < 3.2]
    assert min(d.distance(straight) for d in s_road) > 0.55


def test_the_crosswalk_encloses_seven_stripes_and_two_stop_lines() -> None:
    rectangle = shapely.Polygon(COURSE.crosswalk_corners)
    inside = [p for p in COURSE.paint if rectangle.buffer(1e-6).contains(p)]
    assert len(inside) == 9
    assert shapely.union_all(inside).bounds == pytest.approx(rectangle.bounds)


def test_the_solid_lines_leave_the_bulge_open() -> None:
    gap = COURSE.distance_to_edge_lines_m(np.array([(2.85, -3.0), (-2.85, -3.0)]))
    assert gap[0] > 0.5 and gap[1] == pytest.approx(0.0, abs=1e-9)


def test_the_lap_passes_the_crosswalk_a_second_time_half_way_round() -> None:
    back = COURSE.lap.pose(COURSE.crosswalk_back_m)
    assert (back.x_m, back.y_m) == pytest.approx((0.0, -1.8375)) and math.cos(back.yaw_rad) == pytest.approx(-1.0)
