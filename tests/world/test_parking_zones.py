"""Free places and the floor before the bay, against the drawn lines and boxes."""

import pytest
import shapely

from adc_bench.world.course import COURSE_SETS, Course, CourseSpec
from adc_bench.world.drawing import box_floor
from adc_bench.world.layout import Layout
from adc_bench.world.parking_zones import bay_apron, bay_limits, free_places
from adc_bench.world.setup import draw_layout, load_layout
from adc_bench.world.streams import stream

COURSE = Course()


@pytest.mark.parametrize("spec", COURSE_SETS.values(), ids=list(COURSE_SETS))
def test_the_free_bay_is_one_place_and_the_two_place_bay_is_two(spec: CourseSpec) -> None:
    course = Course(spec=spec)
    (bulge,) = free_places(course, Layout(), "parallel")
    assert shapely.get_coordinates(bulge)[:4] == pytest.approx(course.bulge_corners)
    near, far = free_places(course, Layout(), "bay")
    paint = shapely.union_all([course.bay_paint[0], *course.bay_paint[1:3]])
    assert near.centroid.x > far.centroid.x and not near.intersects(far)
    for place in (near, far):
        assert shapely.area(place.intersection(course.bay_paint[0])) == pytest.approx(0.0, abs=1e-9)
        assert place.within(paint.convex_hull) and bay_apron(course).contains(place)


@pytest.mark.parametrize("seed", range(6))
def test_boxes_take_places(seed: int) -> None:
    parallel = draw_layout("random_p2", COURSE, stream(seed, "layout"))
    (gap,) = free_places(COURSE, parallel, "parallel")
    x0, _, x1, _ = gap.bounds
    assert 0.80 <= x1 - x0 <= 0.95 and all(gap.distance(box_floor(box)) < 1e-9 for box in parallel.boxes)
    bay = draw_layout("random_b2", COURSE, stream(seed, "layout"))
    (place,) = free_places(COURSE, bay, "bay")
    assert place in free_places(COURSE, Layout(), "bay") and not place.intersects(box_floor(bay.boxes[0]))


def test_the_published_layouts_leave_what_they_say() -> None:
    near, far = free_places(COURSE, Layout(), "bay")
    assert free_places(COURSE, load_layout("b2_v1"), "bay") == (far,)
    assert free_places(COURSE, load_layout("b2_v2"), "bay") == (near,)
    (gap,) = free_places(COURSE, load_layout("p2"), "parallel")
    assert gap.bounds[2] - gap.bounds[0] == pytest.approx(0.85)


def test_the_bay_is_closed_on_three_sides() -> None:
    limits, outline = bay_limits(COURSE), COURSE.bay_paint[0]
    assert outline.buffer(1e-9).contains(limits)
    x0, y0, x1, y1 = outline.bounds
    half_m = COURSE.spec.bay.line_width_m / 2
    assert limits.distance(shapely.Point(x0 + half_m, y0 + 0.5)) == pytest.approx(0.0)
    assert limits.distance(shapely.Point((x0 + x1) / 2, y0 + half_m)) == pytest.approx(0.0)
    assert limits.distance(shapely.Point((x0 + x1) / 2, y1 - half_m)) > 0.5, "open towards the road"
