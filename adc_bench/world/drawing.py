"""Drawing what is set up for a trial: tunnels, boxes, road-works, parked boxes. Each takes the floor that is taken."""

import math
from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.world.arena import ArenaSpec, Tunnel, road_centre, tunnel_solids
from adc_bench.world.course import Course
from adc_bench.world.footprints import extents
from adc_bench.world.layout import BoxPlace, Layout, Place, Works
from adc_bench.world.route import Loop
from adc_bench.world.works import BOX_SIZE_M, blocked_by, layout_bodies

Array = NDArray[np.float64]
LOOPS = (1, 4)  # the lap's pieces along the +x and the -x loop

TUNNEL_LENGTH_M = (2.0, 4.0)
TUNNEL_GAP_M = 0.15  # from a tunnel to whatever else stands
SECTION_M = 0.05
BEFORE_CROSSWALK_M = (1.0, 3.0)  # where a tunnel over the crosswalk or its approach begins

BOX_APART_M = 3.0  # between the middles of two boxes
BOX_GAP_M = 0.60  # from a box to whatever else stands
BOX_LATERAL_SD_M, BOX_TURN_SD_RAD = 0.03, math.radians(3)
PASSING_M = 0.40  # from a free lane's centre to the next box
START_ZONE_X_M = (-2.2, 1.2)  # of the start straight: no box stands there

CONES = ((6, 3), (5, 4))  # of the outer and the inner row; nine, as in both published works
CONE_SPACING_M = (1.10, 1.30)
CORRIDOR_M = (0.95, 1.10)  # from row to row; published: 0.89 to 1.11
SWING_OUT_M = (0.35, 0.60)  # of the corridor's middle beyond the outer line
WORKS_FROM_RAD, WORKS_TO_RAD = math.radians(-80), math.radians(155)  # of a loop, in its driving direction
CONE_SD_M = 0.02

PARKED_GAP_M = (0.80, 0.95)  # between two boxes in the parallel bay; published: 0.85
PARKED_ASIDE_M, PARKED_TURN_RAD = 0.03, math.radians(2)
PARKED_FROM_LINE_M = 0.393  # from the bay's dashed line to the boxes' middles, as published


def draw_loop_tunnel(course: Course, taken: shapely.Geometry, rng: np.random.Generator) -> Tunnel:
    """Draw a tunnel over a part of one of the two loops, clear of what is taken."""
    free = {piece: _free_sections(course, piece, taken) for piece in LOOPS}
    while True:
        length_m = float(rng.uniform(*TUNNEL_LENGTH_M))
        starts = [(piece, k) for piece in LOOPS for k in _free_starts(free[piece], length_m)]
        if starts:
            piece, section = starts[int(rng.integers(len(starts)))]
            share = (section + float(rng.uniform(0.0, 1.0))) * SECTION_M / _middle_m(course, piece)
            start_m = course.lap.knots_m[piece] + share * course.lap.pieces[piece].length_m
            return Tunnel(start_s_m=float(start_m), length_m=length_m)


def _middle_m(course: Course, piece: int) -> float:
    """Return the length of the road's middle along a piece of the lap."""
    return road_centre(course).pieces[piece].length_m


def _free_sections(course: Course, piece: int, taken: shapely.Geometry) -> NDArray[np.bool_]:
    """Return for cuts across the road, `SECTION_M` apart along a loop, whether a tunnel's hoop could stand there."""
    middle = road_centre(course)
    stations = middle.poses(middle.knots_m[piece] + np.arange(0.0, middle.pieces[piece].length_m, SECTION_M))
    across = (ArenaSpec().tunnel_clear_half_width_m + TUNNEL_GAP_M) * np.stack(
        [-np.sin(stations[:, 2]), np.cos(stations[:, 2])], axis=1
    )
    hoops = shapely.linestrings(np.stack([stations[:, :2] - across, stations[:, :2] + across], axis=1))
    free: NDArray[np.bool_] = shapely.distance(hoops, taken) > TUNNEL_GAP_M
    return free


def _free_starts(free: NDArray[np.bool_], length_m: float) -> list[int]:
    """Return the sections from which a tunnel of this length finds all sections free."""
    count = math.ceil(length_m / SECTION_M) + 2
    return [k for k in range(len(free) - count + 1) if free[k : k + count].all()]


def draw_crosswalk_tunnel(course: Course, rng: np.random.Generator) -> Tunnel:
    """Draw a tunnel that begins before one of the lap's two passes of the crosswalk and often covers it."""
    length_m = float(rng.uniform(*TUNNEL_LENGTH_M))
    start_m = float(rng.choice([0.0, course.crosswalk_back_m])) - float(rng.uniform(*BEFORE_CROSSWALK_M))
    return Tunnel(start_s_m=start_m % course.lap.length_m, length_m=length_m)


def tunnel_floor(course: Course, tunnel: Tunnel) -> shapely.Geometry:
    """Return the floor that a tunnel covers."""
    things = extents([solid for solid in tunnel_solids(ArenaSpec(), course, tunnel) if "roof" in solid.name])
    return shapely.union_all([things.footprint(k) for k in range(len(things.owner))])


def draw_boxes(course: Course, taken: shapely.Geometry, rng: np.random.Generator) -> tuple[BoxPlace, ...]:
    """Draw one box in one lane, or one in each, so that at every place of the lap one of the two lanes is free."""
    lanes = rng.permutation(["right", "left"])[: int(rng.integers(1, 3))]
    boxes: list[BoxPlace] = []
    for lane in lanes:
        while True:
            box = _draw_box(course, str(lane), rng)
            if _box_fits(course, box, boxes, taken):
                boxes.append(box)
                break
    return tuple(boxes)


def box_floor(box: BoxPlace) -> shapely.Polygon:
    """Return the floor that a box covers."""
    x, y = BOX_SIZE_M[0] / 2, BOX_SIZE_M[1] / 2
    pose = Pose2(x_m=box.x_m, y_m=box.y_m, yaw_rad=box.yaw_rad)
    return shapely.Polygon(pose.transform([(x, y), (-x, y), (-x, -y), (x, -y)]))


def _draw_box(course: Course, lane: str, rng: np.random.Generator) -> BoxPlace:
    path = course.lanes[lane]
    aside_m, turn_rad = BOX_LATERAL_SD_M * rng.standard_normal(), BOX_TURN_SD_RAD * rng.standard_normal()
    on_lane = path.pose(float(rng.uniform(0.0, path.length_m)))
    pose = on_lane @ Pose2(x_m=0.0, y_m=float(aside_m), yaw_rad=float(turn_rad))
    return BoxPlace(x_m=pose.x_m, y_m=pose.y_m, yaw_rad=pose.yaw_rad)


def _box_fits(course: Course, box: BoxPlace, others: list[BoxPlace], taken: shapely.Geometry) -> bool:
    low, high = START_ZONE_X_M
    start_zone = shapely.box(low, -course.spec.radius_outer_m, high, -course.spec.radius_inner_m)
    if box_floor(box).intersects(start_zone):
        return False
    if any(math.hypot(box.x_m - other.x_m, box.y_m - other.y_m) < BOX_APART_M for other in others):
        return False
    if box_floor(box).distance(taken) < BOX_GAP_M:
        return False
    return free_lane_m(course, [*others, box]) > PASSING_M


def free_lane_m(course: Course, boxes: list[BoxPlace]) -> float:
    """Return how near boxes come to the centre of the freer lane, where they come nearest, along the lap."""
    floor = shapely.union_all([box_floor(box) for box in boxes])
    share = np.linspace(0.0, 1.0, 401)
    clear = [
        shapely.distance(floor, shapely.points(lane.poses(_stations(lane.knots_m, share))[:, :2]))
        for lane in course.lanes.values()
    ]
    return float(np.maximum(*clear).min())


def _stations(knots_m: Array, share: Array) -> Array:
    """Return arc lengths at shares of a lane's pieces, so that stations of parallel lanes lie side by side."""
    stations: Array = np.interp(share * (len(knots_m) - 1), np.arange(len(knots_m)), knots_m)
    return stations


def draw_works(course: Course, rng: np.random.Generator, *, loops: Sequence[Loop] = ("east", "west")) -> Works:
    """Draw road-works outside one of these loops: the way leaves the road over the outer line and comes back to it."""
    while True:
        works = _draw_works(course, rng)
        if works_loop(works) in loops and not blocked_by(works, extents([], layout_bodies(Layout(works=works)))):
            return works


def works_loop(works: Works) -> Loop:
    """Return the loop round which road-works lie."""
    return "east" if sum(x_m for x_m, _ in (*works.left, *works.right)) > 0 else "west"


def works_floor(works: Works) -> shapely.Geometry:
    """Return the floor that road-works cover, with all between the rows."""
    return shapely.MultiPoint([*works.left, *works.right]).convex_hull


def _draw_works(course: Course, rng: np.random.Generator) -> Works:
    outer_count, inner_count = CONES[int(rng.integers(len(CONES)))]
    first = int(rng.integers(outer_count - inner_count + 1))  # the outer cone beside the inner row's first
    width_m = float(rng.uniform(*CORRIDOR_M))
    middle = _corridor_middle(course, (outer_count - 1) * float(rng.uniform(*CONE_SPACING_M)), rng)
    stations = middle[np.linspace(0, len(middle) - 1, outer_count).astype(int)]
    normals = np.stack([np.sin(stations[:, 2]), -np.cos(stations[:, 2])], axis=1)  # away from the loop
    outer = stations[:, :2] + width_m / 2 * normals
    inner = (stations[:, :2] - width_m / 2 * normals)[first : first + inner_count]
    outer, inner = (row + CONE_SD_M * rng.standard_normal(row.shape) for row in (outer, inner))
    if rng.random() < 0.5:
        return Works(left=_places(inner), right=_places(outer))
    mirrored = np.array([-1.0, 1.0])
    return Works(left=_places(outer * mirrored), right=_places(inner * mirrored))


def _corridor_middle(course: Course, length_m: float, rng: np.random.Generator) -> Array:
    """Return the middle of a corridor round the +x loop, counter-clockwise: poses (n, 3). It begins and ends in the
    outer lane and swings out beyond the outer line in between.
    """
    c = course.spec
    swing_m = c.radius_outer_m - c.lane_outer_radius_m + float(rng.uniform(*SWING_OUT_M))
    span_rad = length_m / (c.lane_outer_radius_m + 0.6 * swing_m)
    start_rad = float(rng.uniform(WORKS_FROM_RAD, WORKS_TO_RAD - span_rad))
    peak = float(rng.uniform(0.4, 0.6))
    share = np.linspace(0.0, 1.0, 201)
    rise = np.where(share < peak, share / peak, (1 - share) / (1 - peak))
    radius = c.lane_outer_radius_m + swing_m * (1 - np.cos(np.pi * rise)) / 2
    angle = start_rad + span_rad * share
    points = np.stack([c.loop_centre_x_m + radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    along = np.gradient(points, axis=0)
    return np.concatenate([points, np.arctan2(along[:, 1], along[:, 0])[:, None]], axis=1)


def _places(row: Array) -> tuple[Place, ...]:
    return tuple((round(float(x), 4), round(float(y), 4)) for x, y in row)


def draw_parked(course: Course, rng: np.random.Generator) -> tuple[BoxPlace, ...]:
    """Draw boxes that occupy parking places: two in the parallel bay, one in the two-place bay, or both."""
    which = int(rng.integers(3))
    parallel = draw_parallel_parked(course, rng) if which != 1 else ()
    return parallel + (draw_bay_parked(course, rng) if which != 0 else ())


def draw_parallel_parked(course: Course, rng: np.random.Generator) -> tuple[BoxPlace, BoxPlace]:
    """Draw two boxes in the parallel bay, with a gap between them."""
    parallel = course.parking_places[0]
    gap_m = float(rng.uniform(*PARKED_GAP_M))
    apart_m = (gap_m + BOX_SIZE_M[0]) / 2
    free_m = parallel.length_m / 2 - apart_m - BOX_SIZE_M[0] / 2
    middle_m = parallel.pose.x_m + float(rng.uniform(-free_m, free_m))
    y_m = -course.spec.radius_outer_m - PARKED_FROM_LINE_M
    return BoxPlace(x_m=middle_m - apart_m, y_m=y_m), BoxPlace(x_m=middle_m + apart_m, y_m=y_m)


def draw_bay_parked(course: Course, rng: np.random.Generator) -> tuple[BoxPlace]:
    """Draw a box in one place of the two-place bay."""
    bay = course.parking_places[1:]
    place = bay[int(rng.integers(len(bay)))].pose
    aside_m, turn_rad = rng.uniform(-1.0, 1.0, 2) * (PARKED_ASIDE_M, PARKED_TURN_RAD)
    pose = place @ Pose2(x_m=0.0, y_m=float(aside_m), yaw_rad=float(turn_rad))
    return (BoxPlace(x_m=pose.x_m, y_m=pose.y_m, yaw_rad=pose.yaw_rad),)
