"""What stands and what can be pushed: boxes, cones, tapes, signs, furniture, robots."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import shapely

from adc_bench.world.arena import ArenaSpec
from adc_bench.world.categories import CATEGORIES, SIGNS
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.footprints import extents
from adc_bench.world.furniture import CABINETS, CHAIRS, PEOPLE, POSTERS, Furniture, chair_body, furniture_solids
from adc_bench.world.robot import ROBOTS
from adc_bench.world.scenario import Scenario
from adc_bench.world.setup import load_layout
from adc_bench.world.signs import SQUARES, TRIANGLES, board_outline, draw_signs, sign_solids
from adc_bench.world.solids import Body
from adc_bench.world.streams import stream

SetUp = Callable[..., Scenario]
COURSE = Course()


def height_m(body: Body) -> tuple[float, float]:
    bounds = extents([], [body])
    return float(bounds.low[:, 2].min()), float(bounds.high[:, 2].max())


def test_boxes_and_cones_have_the_published_figures(arena: SetUp) -> None:
    boxes = arena(layout=load_layout("d3_v1"), furniture=False).bodies
    assert [body.name for body in boxes] == ["box_0", "box_1"]
    for box in boxes:
        assert (box.mass_kg, box.category, box.parts[0].size_m) == (10.0, "box", (0.60, 0.60, 0.30))
        assert height_m(box) == pytest.approx((0.0, 0.30))
    cones = arena(layout=load_layout("d4_v1"), furniture=False).bodies
    assert [body.name for body in cones] == [
        *(f"cone_left_{k}" for k in range(3)),
        *(f"cone_right_{k}" for k in range(6)),
    ]
    for cone in cones:
        assert (cone.mass_kg, cone.category) == (4.0, "cone")
        assert height_m(cone) == pytest.approx((0.0, 0.23))
        foot, top = cone.parts
        assert foot.size_m[:2] == (0.15, 0.15) and (foot.shape, top.shape) == ("box", "cone")


def test_tapes_join_the_cones_of_a_row(arena: SetUp) -> None:
    scenario = arena(layout=load_layout("d4_v2"), furniture=False)
    places = {body.name: (body.pose.x_m, body.pose.y_m) for body in scenario.bodies}
    assert [tape.name for tape in scenario.tapes] == [
        *(f"tape_left_{k}" for k in range(5)),
        *(f"tape_right_{k}" for k in range(2)),
    ]
    assert (scenario.tapes[0].first, scenario.tapes[0].second) == ("cone_left_0", "cone_left_1")
    for tape in scenario.tapes:
        span_m = math.dist(places[tape.first], places[tape.second])
        assert span_m < tape.rest_length_m < 1.02 * span_m
    assert arena().tapes == ()


def test_the_twelve_signs_are_permuted_by_the_seed() -> None:
    spec = CourseSpec()
    drawn = [draw_signs(spec, stream(seed, "signs")) for seed in range(60)]
    for signs in drawn:
        assert [sign.name for sign in signs] == [f"sign_{k}" for k in range(12)]
        assert {sign.sign for sign in signs} == set(SIGNS)
        assert [(s.x_m, s.y_m, s.yaw_rad) for s in signs] == [(s.x_m, s.y_m, s.yaw_rad) for s in drawn[0]]
    assert len({tuple(sign.sign for sign in signs) for signs in drawn}) == 60
    assert all(len({signs[place].sign for signs in drawn}) > 8 for place in range(12))
    assert drawn[7] == draw_signs(spec, stream(7, "signs"))


def test_a_sign_has_its_board_at_75_cm_before_a_post_with_a_base() -> None:
    for sign in draw_signs(CourseSpec(), stream(1, "signs")):
        board, post, base = sign_solids(sign)
        assert [solid.name for solid in (board, post, base)] == [sign.name, f"{sign.name}_post", f"{sign.name}_base"]
        assert {solid.kind for solid in (board, post, base)} == {"sign"}
        assert board.centre_m[2] == 0.75 and board.size_m[1:] == (0.305, 0.305)
        assert post.centre_m[2] + post.size_m[2] / 2 == pytest.approx(0.82) and base.size_m[2] == 0.05
        front = board.pose_world_solid().rotation[:, 0]
        assert front[:2] == pytest.approx((math.cos(sign.yaw_rad), math.sin(sign.yaw_rad)))
        ahead = (np.array(board.centre_m) - post.centre_m)[:2] @ front[:2]
        assert ahead - board.size_m[0] / 2 == pytest.approx(post.size_m[0] / 2)
        assert post.centre_m[:2] == base.centre_m[:2] == pytest.approx((sign.x_m, sign.y_m))


def test_boards_are_triangles_squares_and_circles_of_305_mm() -> None:
    corners = []
    for sign in draw_signs(CourseSpec(), stream(1, "signs")):
        outline = board_outline(sign)
        polygon = shapely.Polygon(outline)
        assert polygon.is_valid and polygon.exterior.is_ccw
        assert polygon.bounds == pytest.approx((-0.1525, -0.1525, 0.1525, 0.1525))
        full = {True: 0.5, False: 1.0}[sign.sign in TRIANGLES] if sign.sign in TRIANGLES + SQUARES else math.pi / 4
        assert polygon.area == pytest.approx(full * 0.305**2, rel=0.003)
        corners.append(len(outline))
    assert sorted(corners)[:8] == [3, 3, 3, 3, 4, 4, 4, 4] and min(sorted(corners)[8:]) >= 32
    triangle = next(board_outline(s) for s in draw_signs(CourseSpec(), stream(1, "x")) if s.sign == "sign_danger")
    assert (triangle[:, 1] < 0).sum() == 2  # it stands on its base


@pytest.mark.parametrize(
    ("kind", "variants"),
    [("cabinet", len(CABINETS)), ("person", len(PEOPLE)), ("poster", len(POSTERS)), ("chair", len(CHAIRS))],
)
def test_furniture_stands_on_the_floor_within_its_circle(kind: str, variants: int) -> None:
    for variant in range(variants):
        piece = Furniture(name=f"{kind}_0", kind=kind, x_m=1.0, y_m=5.0, yaw_rad=0.6, variant=variant)
        bodies = [chair_body(piece)] if kind == "chair" else []
        bounds = extents(furniture_solids(piece), bodies)
        assert set(bounds.owner) == {f"{kind}_0"}
        reach = np.concatenate([bounds.low[:, :2], bounds.high[:, :2]]) - (1.0, 5.0)
        assert np.abs(reach).max() < {"cabinet": 1.0, "poster": 1.3}.get(kind, 0.35)
        if kind == "poster":
            assert bounds.low[0, 2] > 0.25 and bounds.high[0, 2] < 3.0
        else:
            assert bounds.low[:, 2].min() == pytest.approx(0.0)
        if kind == "person":
            assert 1.5 < bounds.high[:, 2].max() < 1.9
        names = [solid.name for solid in (*furniture_solids(piece), *(part for b in bodies for part in b.parts))]
        assert len(set(names)) == len(names) and all(name.startswith(f"{kind}_0") for name in names)


def test_a_hall_looks_like_a_competition_hall_at_every_seed(arena: SetUp) -> None:
    for seed in range(60):
        scenario = arena(seed=seed, layout=load_layout("v1"))
        kinds = [piece.kind for piece in scenario.furniture]
        for kind, least in {"cabinet": 3, "poster": 4, "person": 4, "chair": 3}.items():
            assert kinds.count(kind) >= least
        for piece in scenario.furniture:
            if piece.kind == "poster":  # flat on a wall
                arena_spec = ArenaSpec()
                off_wall = min(
                    arena_spec.hall_half_length_m - abs(piece.x_m), arena_spec.hall_half_width_m - abs(piece.y_m)
                )
                assert 0.0 < off_wall < 0.03
        bodies = extents(scenario.solids, scenario.bodies)
        road = COURSE.road.buffer(0.3)
        for k, owner in enumerate(bodies.owner):
            if owner.startswith(("cabinet", "person", "chair")):
                assert not bodies.footprint(k).intersects(road)
        names = [solid.name for solid in scenario.solids] + [body.name for body in scenario.bodies]
        assert len(set(names)) == len(names)


def test_only_boxes_and_cones_are_bodies_with_a_category(arena: SetUp) -> None:
    scenario = arena(layout=load_layout("d3_v1"))
    assert {body.category for body in scenario.bodies} == {"box", None}
    assert all(body.category in CATEGORIES for body in scenario.bodies if body.category)
    assert {body.kind for body in scenario.bodies if body.category is None} == {"chair"}


def test_the_three_robots_have_the_published_figures() -> None:
    pioneer, stock, conde = (ROBOTS[name] for name in ("pioneer", "pioneer-stock", "conde"))
    assert all(robot.name == name for name, robot in ROBOTS.items())
    assert (pioneer.wheel_radius_m, pioneer.wheel_separation_m, pioneer.mass_kg) == (0.0975, 0.33, 9.0)
    assert (pioneer.speed_max_mps, stock.speed_max_mps) == (2.2, 1.2)
    assert (conde.wheel_radius_m, conde.wheel_separation_m, conde.mass_kg) == (0.032, 0.33, 10.6)
    assert all(robot.width_m <= 0.60 and robot.length_m <= 1.00 for robot in ROBOTS.values())
