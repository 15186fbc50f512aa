"""From the name of a layout to the layout: read from a file, or drawn."""

from functools import lru_cache
from typing import Literal, get_args

import numpy as np
import shapely

from adc_bench.errors import InputError
from adc_bench.world.arena import ArenaSpec, Tunnel, gantry_solids
from adc_bench.world.categories import PanelSign
from adc_bench.world.checks import check_layout, check_scenario
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.drawing import (
    draw_bay_parked,
    draw_boxes,
    draw_crosswalk_tunnel,
    draw_loop_tunnel,
    draw_parallel_parked,
    draw_parked,
    draw_works,
    tunnel_floor,
    works_floor,
)
from adc_bench.world.footprints import extents
from adc_bench.world.furnishing import draw_furniture
from adc_bench.world.layout import BoxPlace, Layout, Works
from adc_bench.world.look import Look
from adc_bench.world.records import find_record, load_record
from adc_bench.world.robot import RobotParams, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.signs import draw_signs, sign_solids
from adc_bench.world.streams import stream

RandomLayout = Literal[
    "random_tunnel",
    "crosswalk_tunnel",
    "random_boxes",
    "random_works",
    "random_parking",
    "random_all",
    "random_d3",
    "random_d4",
    "random_p2",
    "random_b2",
]
RANDOM_LAYOUTS: tuple[str, ...] = get_args(RandomLayout)
WORKS_CLEAR_M = 1.5  # from road-works to a tunnel, and more to boxes: room to find the way in and out


def load_layout(name_or_path: str) -> Layout:
    """Return the layout of this name (`splits/layouts/NAME.toml`) or of this file.

    Raises:
        InputError: it is unknown, its file is broken, or the arena that it makes cannot be.
    """
    try:
        path = find_record(name_or_path, "splits/layouts")
    except InputError as error:
        drawn = f"one of the drawn {', '.join(RANDOM_LAYOUTS)}"
        raise InputError(
            where=error.where, found=error.found, wanted=f"{error.wanted}; or {drawn}", todo=error.todo
        ) from None
    layout = load_record(path, Layout)
    check_layout(layout, str(path))
    return layout


def draw_layout(name: str, course: Course, rng: np.random.Generator, *, signs: bool = False) -> Layout:
    """Return the layout of this name: one of `RANDOM_LAYOUTS` drawn, with the vertical signs or without, or a file's.

    Road-works take the floor round a loop on which signs stand, so a layout with road-works has none. `random_all` has
    road-works, a tunnel and boxes in the lanes. The layouts of the suites: `random_d3` has a tunnel and boxes,
    `random_d4` road-works in the way of the lap as well, and nothing beside the parallel bay; `random_p2` and
    `random_b2` have parked boxes.

    Raises:
        InputError: as `load_layout`.
    """
    taken, bare = (_fixed_floor(course.spec, signs=standing) for standing in (signs, False))
    if name == "random_tunnel":
        return Layout(name=name, tunnel=draw_loop_tunnel(course, taken, rng), signs=signs)
    if name == "crosswalk_tunnel":
        return Layout(name=name, tunnel=draw_crosswalk_tunnel(course, rng), signs=signs)
    if name == "random_boxes":
        return Layout(name=name, boxes=draw_boxes(course, taken, rng), signs=signs)
    if name == "random_parking":
        return Layout(name=name, boxes=draw_parked(course, rng), signs=signs)
    if name == "random_works":
        return Layout(name=name, works=draw_works(course, rng))
    if name == "random_all":
        return _draw_all(name, draw_works(course, rng), bare, course, rng)
    if name == "random_d3":
        tunnel = draw_loop_tunnel(course, taken, rng)
        return Layout(name=name, tunnel=tunnel, boxes=_draw_boxes_round(course, tunnel, taken, rng), signs=signs)
    if name == "random_d4":
        works = draw_works(course, rng, loops=("east",))
        clear = [works_floor(works).buffer(WORKS_CLEAR_M), _beside_parallel_bay(course.spec)]
        return _draw_all(name, works, shapely.union_all([bare, *clear]), course, rng)
    if name == "random_p2":
        return Layout(name=name, boxes=draw_parallel_parked(course, rng))
    if name == "random_b2":
        return Layout(name=name, boxes=draw_bay_parked(course, rng))
    return load_layout(name)


def set_up(
    *,
    name: str,
    seed: int,
    look: Look,
    panel_sign: PanelSign,
    layout: Layout,
    course: CourseSpec,
    arena: ArenaSpec,
    robot: RobotParams,
    rig: SensorRig,
    furniture: bool = True,
) -> Scenario:
    """Return the scenario: what the layout asks for, and what the seed draws beside it (signs, furniture, the robot).

    Raises:
        InputError: the arena cannot be, see `check_scenario`.
    """
    signs = draw_signs(course, stream(seed, "signs")) if layout.signs else ()
    hall = stream(seed, "furniture")
    scenario = Scenario(
        name=name,
        seed=seed,
        look=look,
        robot_truth=draw_robot_truth(robot, stream(seed, "robot")),
        panel_sign=panel_sign,
        layout=layout,
        signs=signs,
        furniture=draw_furniture(arena, Course(spec=course), layout, signs, hall) if furniture else (),
        course_spec=course,
        arena_spec=arena,
        robot=robot,
        rig=rig,
    )
    check_scenario(scenario, f"the arena {name}")
    return scenario


def _draw_all(name: str, works: Works, taken: shapely.Geometry, course: Course, rng: np.random.Generator) -> Layout:
    taken = shapely.union(taken, works_floor(works))
    tunnel = draw_loop_tunnel(course, taken, rng)
    return Layout(name=name, works=works, tunnel=tunnel, boxes=_draw_boxes_round(course, tunnel, taken, rng))


def _draw_boxes_round(
    course: Course, tunnel: Tunnel, taken: shapely.Geometry, rng: np.random.Generator
) -> tuple[BoxPlace, ...]:
    return draw_boxes(course, shapely.union(taken, tunnel_floor(course, tunnel)), rng)


def _beside_parallel_bay(spec: CourseSpec) -> shapely.Polygon:
    return shapely.box(spec.bulge_start_x_m, -spec.radius_outer_m, spec.loop_centre_x_m, -spec.radius_centre_m)


@lru_cache(maxsize=8)
def _fixed_floor(spec: CourseSpec, *, signs: bool) -> shapely.Geometry:
    """Return what the gantry's posts cover, and the signs, boards included, whichever stands where."""
    posts = [solid for solid in gantry_solids(ArenaSpec(), Course(spec=spec)) if "post" in solid.name]
    boards = [solid for sign in draw_signs(spec, stream(0, "signs")) for solid in sign_solids(sign)] if signs else []
    things = extents([*posts, *boards])
    return shapely.union_all([things.footprint(k) for k in range(len(things.owner))])
