"""Where a robot may park in a set-up, and the floor that it may cross on the way there."""

import numpy as np
import shapely

from adc_bench.world.course import Course
from adc_bench.world.drawing import box_floor
from adc_bench.world.layout import Layout
from adc_bench.world.parking import ParkingKind, ParkingPlace

APRON_M = 0.50  # beside the two-place bay: room to turn in


def free_places(course: Course, layout: Layout, kind: ParkingKind) -> tuple[shapely.Polygon, ...]:
    """Return the floor of each free place of a kind: a robot is parked when all of it lies in one of them.

    Parallel: the bulge up to its lines' centres; with boxes in it, the gap between them. Bay: the places, between their
    lines, in which no box stands.
    """
    boxes = [box_floor(box) for box in layout.boxes]
    parallel, *bay = course.parking_places
    if kind == "bay":
        return tuple(place for place in map(_outline, bay) if not any(place.intersects(box) for box in boxes))
    bulge = shapely.Polygon(course.bulge_corners)
    parked = sorted((box for box in boxes if box.intersects(_outline(parallel))), key=lambda box: box.bounds[0])
    if len(parked) < 2:
        return (bulge,)
    _, low_m, _, high_m = bulge.bounds
    return (bulge & shapely.box(parked[0].bounds[2], low_m, parked[1].bounds[0], high_m),)


def bay_apron(course: Course) -> shapely.Polygon:
    """Return the two-place bay with the floor between it and the road, `APRON_M` wider on both sides."""
    x0_m, y0_m, x1_m, _ = _bay_bounds(course)
    return shapely.box(x0_m - APRON_M, y0_m, x1_m + APRON_M, -course.spec.radius_outer_m + 0.1)


def bay_limits(course: Course) -> shapely.LineString:
    """Return the middle of the bay's lines at its far end and at its two sides; towards the road it is open."""
    x0_m, y0_m, x1_m, y1_m = _bay_bounds(course)
    half_m = course.spec.bay.line_width_m / 2
    x0_m, y0_m, x1_m, y1_m = x0_m + half_m, y0_m + half_m, x1_m - half_m, y1_m - half_m
    return shapely.LineString([(x0_m, y1_m), (x0_m, y0_m), (x1_m, y0_m), (x1_m, y1_m)])


def _bay_bounds(course: Course) -> tuple[float, float, float, float]:
    x0_m, y0_m, x1_m, y1_m = course.bay_paint[0].bounds
    return x0_m, y0_m, x1_m, y1_m


def _outline(place: ParkingPlace) -> shapely.Polygon:
    half = np.array([place.length_m, place.width_m]) / 2
    return shapely.Polygon(place.pose.transform(half * [(1, 1), (-1, 1), (-1, -1), (1, -1)]))
