"""The course against the published figures (set A) and against itself."""

import math

import numpy as np
import pytest
import shapely

from adc_bench.world.course import Course, CourseSpec

COURSE = Course()
SET_B = CourseSpec(
    loop_centre_x_m=5.30,
    s_road_centre_x_m=0.60,
    radius_outer_m=3.15,
    radius_centre_m=2.35,
    radius_inner_m=1.55,
    edge_line_width_m=0.10,
)


def test_a_lap_in_the_right_lane_is_40_46_m_and_closes() -> None:
    assert round(COURSE.lap.length_m, 2) == 40.46
    assert COURSE.lap.length_m == pytest.approx(2 * math.pi * 4.45 + 12.5)
    end = COURSE.lap.poses(COURSE.lap.length_m - 1e-9)[0]
    assert np.allclose(end[:2], [0.0, -2.6125], atol=1e-6)
    assert math.isclose(math.cos(end[2]), 1.0, abs_tol=1e-9)


@pytest.mark.parametrize("spec", [CourseSpec(), SET_B])
def test_the_lap_is_driven_in_the_published_lanes_and_senses(spec: CourseSpec) -> None:
    course = Course(spec=spec)
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


def test_tangency_closes_the_course() -> None:
    c = COURSE.spec
    assert c.loop_centre_x_m - c.s_road_centre_x_m == pytest.approx(2 * c.radius_centre_m)
    assert COURSE.lap.poses(COURSE.lap.knots_m[2])[0][
        0
    ] - c.lane_inner_radius_m + c.lane_inner_radius_m == pytest.approx(2.7375)


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


def test_gates_follow_the_lap_and_end_at_the_start_line() -> None:
    s = [gate.s_m for gate in COURSE.gates]
    assert s[:-1] == sorted(s[:-1]) and s[-1] == 0.0
    assert COURSE.gates[-1].pose.x_m == pytest.approx(0.0)
