"""Which places are free, from what the laser met: boxes stand in the others."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import LaserScan
from adc_bench.geometry import Pose2
from adc_bench.world.course import Course
from adc_bench.world.parking import ParkingKind, ParkingPlace
from adc_bench.world.sensors import LaserSpec

Array = NDArray[np.float64]

INSET_M = 0.06  # what the laser meets so near to a place's border may stand outside
APART_M = 0.30  # points along the road farther apart belong to two things
FEWEST = 8  # points that make a thing
TAIL_FIRST = Pose2(x_m=0.0, y_m=0.0, yaw_rad=math.pi)


def points_met(scan: LaserScan, laser: LaserSpec, pose: Pose2) -> Array:
    """Return the points (n, 2) in the world that a scan met, taken by a robot at this pose."""
    met = (scan.ranges_m > laser.range_min_m) & (scan.ranges_m < laser.range_max_m)
    angles = np.flatnonzero(met) * laser.step_rad - laser.field_rad / 2
    ranges = scan.ranges_m[met]
    return pose.transform(np.column_stack([laser.x_m + ranges * np.cos(angles), ranges * np.sin(angles)]))


def places_of(course: Course, kind: ParkingKind) -> tuple[ParkingPlace, ...]:
    """Return the places of a kind, in the order in which the start straight passes them."""
    parallel, *bay = course.parking_places
    return (parallel,) if kind == "parallel" else tuple(sorted(bay, key=lambda place: place.pose.x_m))


def free_pose(course: Course, kind: ParkingKind, points_world: Array) -> Pose2:
    """Return where to stand, given the points (n, 2) that the laser met: in the middle of what is free.

    In the parallel place that is along the road: between two boxes their gap's middle, beside one the wider side's. Of
    the two-place bay's it is the emptier place, the first one passed of two alike, with the tail to its far end.
    """
    places = places_of(course, kind)
    if kind == "parallel":
        return _in_gap(places[0], points_world)
    counts = [len(_inside(place, points_world)) for place in places]
    taken = [count >= FEWEST for count in counts]
    return places[taken.index(min(taken))].pose @ TAIL_FIRST


def _inside(place: ParkingPlace, points_world: Array) -> Array:
    """Return those of the points, (m, 2) and seen from the place, that lie in it."""
    seen = place.pose.inverse().transform(points_world)
    half = np.array([place.length_m, place.width_m]) / 2 - INSET_M
    kept: Array = seen[(np.abs(seen) <= half).all(axis=1)]
    return kept


def _in_gap(place: ParkingPlace, points_world: Array) -> Pose2:
    along = np.sort(_inside(place, points_world)[:, 0])
    things = [part for part in np.split(along, np.flatnonzero(np.diff(along) > APART_M) + 1) if len(part) >= FEWEST]
    ends = [(float(part[0]), float(part[-1])) for part in things]
    if len(ends) < 2:
        half_m = place.length_m / 2
        ends = [(-half_m, -half_m), *ends, (half_m, half_m)]
    gaps = [(after[0] - before[1], (after[0] + before[1]) / 2) for before, after in pairwise(ends)]
    _, middle_m = max(gaps)
    return place.pose @ Pose2(x_m=middle_m, y_m=0.0, yaw_rad=0.0)
