"""From the name of a layout to the layout: read from a file, or drawn."""

from functools import lru_cache
from typing import Literal, get_args

import numpy as np
import shapely

from adc_bench.errors import InputError
from adc_bench.world.arena import ArenaSpec, gantry_solids
from adc_bench.world.categories import PanelSign
from adc_bench.world.checks import check_layout, check_scenario
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.drawing import (
    draw_boxes,
    draw_crosswalk_tunnel,
    draw_loop_tunnel,
    draw_parked,
    draw_works,
    tunnel_floor,
    works_floor,
)
from adc_bench.world.footprints import extents
from adc_bench.world.furnishing import draw_furniture
from adc_bench.world.layout import Layout
from adc_bench.world.look import Look
from adc_bench.world.records import find_record, load_record
from adc_bench.world.robot import RobotParams, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.signs import draw_signs, sign_solids
from adc_bench.world.streams import stream

RandomLayout = Literal[
    "random_tunnel", "crosswalk_tunnel", "random_boxes", "random_works", "random_parking", "random_all"
]
RANDOM_LAYOUTS: tuple[str, ...] = get_args(RandomLayout)


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
    road-works, a tunnel and boxes in the lanes.

    Raises:
        InputError: as `load_layout`.
    """
    taken = _fixed_floor(course.spec, signs=signs)
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
        return _draw_all(name, course, rng)
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


def _draw_all(name: str, course: Course, rng: np.random.Generator) -> Layout:
    works = draw_works(course, rng)
    taken = shapely.union(_fixed_floor(course.spec, signs=False), works_floor(works))
    tunnel = draw_loop_tunnel(course, taken, rng)
    boxes = draw_boxes(course, shapely.union(taken, tunnel_floor(course, tunnel)), rng)
    return Layout(name=name, works=works, tunnel=tunnel, boxes=boxes)


@lru_cache(maxsize=8)
def _fixed_floor(spec: CourseSpec, *, signs: bool) -> shapely.Geometry:
    """Return what the gantry's posts cover, and the signs, boards included, whichever stands where."""
    posts = [solid for solid in gantry_solids(ArenaSpec(), Course(spec=spec)) if "post" in solid.name]
    boards = [solid for sign in draw_signs(spec, stream(0, "signs")) for solid in sign_solids(sign)] if signs else []
    things = extents([*posts, *boards])
    return shapely.union_all([things.footprint(k) for k in range(len(things.owner))])
