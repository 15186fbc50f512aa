"""What is drawn by seed keeps its promises at every seed; judged by shapely and by brute force, not by its own code."""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
import shapely
from scipy import ndimage

from adc_bench.world.course import COURSE_SETS, Course
from adc_bench.world.drawing import draw_boxes, draw_loop_tunnel, draw_parked, draw_works, works_loop
from adc_bench.world.layout import BoxPlace, Works
from adc_bench.world.scenario import Scenario
from adc_bench.world.setup import RANDOM_LAYOUTS, draw_layout
from adc_bench.world.streams import stream

SetUp = Callable[..., Scenario]
COURSES = {name: Course(spec=spec) for name, spec in COURSE_SETS.items()}
BOTH = pytest.mark.parametrize("course", list(COURSES.values()), ids=list(COURSES))
NOTHING = shapely.Point(50.0, 50.0)


def floor_of(box: BoxPlace) -> shapely.Polygon:
    return shapely.affinity.translate(
        shapely.affinity.rotate(shapely.box(-0.3, -0.3, 0.3, 0.3), box.yaw_rad, origin=(0, 0), use_radians=True),
        box.x_m,
        box.y_m,
    )


@BOTH
def test_works_leave_the_road_come_back_and_can_be_driven(course: Course) -> None:
    kinds = set()
    for seed in range(150):
        works = draw_works(course, stream(seed, "works"))
        kinds.add((len(works.left), len(works.right), works.left[0][0] > 0))
        spec = course.spec
        x, y = np.array([*works.left, *works.right]).T
        radius = np.hypot(x - math.copysign(spec.loop_centre_x_m, x[0]), y)
        outer = radius[len(works.left) :] if x[0] > 0 else radius[: len(works.left)]
        assert len(radius) == 9 and outer.max() > spec.radius_outer_m + 0.6
        ends = outer[[0, -1]]
        assert np.all(ends < spec.radius_outer_m + 0.4) and np.all(ends > spec.radius_centre_m + 0.5)
        assert _flooded(works)
    assert len(kinds) == 4  # both loops, both ways to share nine cones


def _flooded(works: Works, cell_m: float = 0.04) -> bool:
    """Brute force: on a grid, floods the places where a disc of 0.60 m keeps clear of cones and tapes."""
    rows = [np.array(works.left), np.array(works.right)]
    outline = np.concatenate([rows[0], rows[1][::-1]])
    low, high = outline.min(axis=0), outline.max(axis=0)
    xs, ys = np.arange(low[0], high[0], cell_m), np.arange(low[1], high[1], cell_m)
    grid = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1)
    points = grid.reshape(-1, 2)
    clear = np.full(len(points), np.inf)
    for row in rows:
        for a, b in pairwise(row):
            share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
            clear = np.minimum(clear, np.linalg.norm(points - a - share[:, None] * (b - a), axis=1) - 0.025)
        for cone in row:
            gap = np.maximum(np.abs(points - cone) - 0.075, 0.0)
            clear = np.minimum(clear, np.hypot(gap[:, 0], gap[:, 1]))
    inside = shapely.contains_xy(shapely.Polygon(outline).buffer(cell_m), points)
    free = ((clear > 0.30 - cell_m / 2) & inside).reshape(grid.shape[:2])
    mouth, end = (_near_line(grid, rows[0][k], rows[1][k], cell_m) for k in (0, -1))
    part, _ = ndimage.label(free)
    return bool((set(part[mouth]) & set(part[end])) - {0})


def _near_line(grid: np.ndarray, a: np.ndarray, b: np.ndarray, reach_m: float) -> np.ndarray:
    share = np.clip((grid - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(grid - a - share[..., None] * (b - a), axis=-1) < reach_m


@BOTH
def test_boxes_never_close_both_lanes_nor_stand_at_the_start(course: Course) -> None:
    counts = set()
    start = shapely.box(-2.2, -course.spec.radius_outer_m, 1.2, -course.spec.radius_inner_m)
    right = course.lanes["right"].sample(0.05)
    for seed in range(100):
        boxes = draw_boxes(course, NOTHING, stream(seed, "boxes"))
        counts.add(len(boxes))
        floor = shapely.union_all([floor_of(box) for box in boxes])
        assert not floor.intersects(start)
        assert course.on_road([(box.x_m, box.y_m) for box in boxes]).all()
        pitch = course.spec.radius_outer_m - course.spec.radius_centre_m
        left = right[:, :2] + pitch * np.stack([-np.sin(right[:, 2]), np.cos(right[:, 2])], axis=1)
        clear = [shapely.distance(floor, shapely.points(lane)) for lane in (right[:, :2], left)]
        assert np.maximum(*clear).min() > 0.38  # half a robot of 0.60 m, and more
        assert min(part.min() for part in clear) == 0.0  # but a lane is blocked
    assert counts == {1, 2}


@BOTH
def test_tunnels_stand_over_a_loop_clear_of_what_is_taken(course: Course) -> None:
    taken = shapely.Point(course.spec.loop_centre_x_m + course.spec.radius_outer_m + 0.2, 0.0)
    for seed in range(200):
        tunnel = draw_loop_tunnel(course, taken, stream(seed, "tunnel"))
        assert 2.0 <= tunnel.length_m <= 4.0
        lap, knots = course.lap, course.lap.knots_m
        piece = 1 if tunnel.start_s_m < knots[3] else 4
        lane_m = tunnel.length_m * lap.pieces[piece].length_m / (1.5 * math.pi * course.spec.radius_centre_m)
        assert knots[piece] <= tunnel.start_s_m and tunnel.start_s_m + lane_m < knots[piece + 1] + 0.01
        covered = lap.poses(np.linspace(tunnel.start_s_m, tunnel.start_s_m + lane_m, 50))[:, :2]
        reach = 0.85 + course.spec.radius_outer_m - course.spec.lane_outer_radius_m
        assert piece == 4 or shapely.LineString(covered).buffer(reach - 0.4, cap_style="flat").distance(taken) > 0


@BOTH
def test_parked_boxes_stand_inside_their_places(course: Course) -> None:
    grounds = [shapely.Polygon(course.bulge_corners)]
    for place in course.parking_places[1:]:
        half = np.array([place.length_m, place.width_m]) / 2
        grounds.append(shapely.Polygon(place.pose.transform(half * [(1, 1), (-1, 1), (-1, -1), (1, -1)])))
    seen = set()
    for seed in range(100):
        boxes = draw_parked(course, stream(seed, "parked"))
        inside = [max(range(3), key=lambda k: grounds[k].intersection(floor_of(box)).area) for box in boxes]
        assert all(grounds[k].buffer(1e-6).contains(floor_of(box)) for k, box in zip(inside, boxes, strict=True))
        seen.add(tuple(inside))
        if inside.count(0):
            assert 0.8 <= abs(boxes[0].x_m - boxes[1].x_m) - 0.6 <= 0.95
    assert seen == {(0, 0), (1,), (2,), (0, 0, 1), (0, 0, 2)}


@pytest.mark.parametrize("name", RANDOM_LAYOUTS)
def test_every_drawn_arena_passes_the_checks(name: str, arena: SetUp) -> None:
    for seed in range(25):
        course = list(COURSES.values())[seed % 2]
        layout = draw_layout(name, course, stream(seed, "layout"), signs=seed % 3 > 0)
        scenario = arena(seed=seed, course=course.spec, layout=layout)
        assert not (layout.signs and layout.works)
        assert len(scenario.signs) == (12 if layout.signs else 0)


def test_the_layout_of_d4_leaves_room_to_find_the_works_and_to_park() -> None:
    course = COURSES["a"]
    bay = shapely.box(0.35, -3.85, 5.35, -2.225)
    for seed in range(25):
        layout = draw_layout("random_d4", course, stream(seed, "layout"))
        assert layout.works and layout.tunnel and layout.boxes
        assert works_loop(layout.works) == "east"
        cones = shapely.MultiPoint([*layout.works.left, *layout.works.right]).convex_hull
        for box in layout.boxes:
            assert floor_of(box).distance(cones) > 2.0 and floor_of(box).distance(bay) > 0.5


def test_equal_seeds_give_equal_arenas(arena: SetUp) -> None:
    course = COURSES["a"]
    first, second = (draw_layout("random_all", course, stream(3, "layout")) for _ in range(2))
    assert first == second and first != draw_layout("random_all", course, stream(4, "layout"))
    assert arena(layout=first) == arena(layout=second)
