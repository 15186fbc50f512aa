"""From a split and a drive's number to its arena and its plan; each depends on nothing else."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adc_bench.dataset.drive_recipe import MISSIONS, SUITING, Behaviour, DriveRecipe, MissionName
from adc_bench.dataset.drive_script import DriveScript
from adc_bench.dataset.driving.driver import CONTROL_PERIOD_S, Hand
from adc_bench.dataset.driving.floor import is_free, taken_floor
from adc_bench.dataset.driving.hand import draw_hand, draw_start
from adc_bench.dataset.driving.leg import Leg
from adc_bench.dataset.driving.missions import BUILDERS
from adc_bench.dataset.driving.parking import is_in
from adc_bench.dataset.driving.task import Task
from adc_bench.dataset.sampling import GOLDEN
from adc_bench.dataset.split import Split
from adc_bench.errors import InputError
from adc_bench.geometry import Pose2
from adc_bench.world.arena import ArenaSpec
from adc_bench.world.course import COURSE_SETS, Course
from adc_bench.world.layout import Layout
from adc_bench.world.look import draw_look
from adc_bench.world.robot import ROBOTS
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream

ATTEMPTS, PER_LAYOUT = 100, 5  # draws of a drive; in each layout
ROOT_2 = math.sqrt(2)  # spreads behaviours independently of missions
CRUISE_MPS: dict[MissionName, tuple[float, float]] = {
    "speed": (0.4, 2.0),
    "signs": (0.5, 1.2),
    "obstacles": (0.4, 1.1),
    "tunnel": (0.4, 1.4),
    "works": (0.45, 0.8),
    "parallel_parking": (0.4, 0.9),
    "bay_parking": (0.4, 0.9),
    "vertical_signs": (0.3, 0.7),
}
LATERAL_MPS2, BRAKING_MPS2 = (0.8, 2.2), (0.5, 1.2)
TIGHT_CARE = 0.3  # of a sloppy driver, where there is little room
CARE: dict[MissionName, float] = {"works": TIGHT_CARE, "parallel_parking": TIGHT_CARE, "bay_parking": TIGHT_CARE}
LAYOUTS: dict[MissionName, tuple[str, ...]] = {
    "speed": ("open",),
    "signs": ("open",),
    "obstacles": ("random_boxes",),
    "tunnel": ("random_tunnel", "crosswalk_tunnel"),
    "works": ("random_works",),
    "parallel_parking": ("open", "random_parking"),
    "bay_parking": ("open", "random_parking"),
    "vertical_signs": ("v1",),
}
PARKED_IN: dict[MissionName, slice] = {"parallel_parking": slice(0, 1), "bay_parking": slice(1, 3)}


@dataclass(frozen=True, kw_only=True, eq=False)
class DrivePlan:
    """A drive before it is driven."""

    script: DriveScript
    legs: tuple[Leg, ...]
    hand: Hand

    @property
    def steps_max(self) -> int:
        """After how many control steps the drive is over at the latest."""
        return len(self.hand.steering_radps)


def draw_drive(split: Split, number: int, rig: SensorRig, salt: bytes | None = None) -> tuple[Scenario, DrivePlan]:
    """Return the arena and the plan of the split's drive of this number; a salted split needs its salt.

    Raises:
        InputError: the arena cannot be, or no drive of the mission fits into it.
    """
    seed = split.seed(split.seed_count - 1 - number, salt)
    mission = mission_of(split.drives, number)
    for attempt in range(ATTEMPTS):
        if attempt % PER_LAYOUT == 0:
            scenario = _draw_scenario(split, number, seed, mission, rig, attempt // PER_LAYOUT)
        plan = _draw_plan(split.drives, scenario, mission, number, attempt)
        if plan:
            return scenario, plan
    raise InputError(
        where=f"drive {number} of split {split.name!r}",
        found=f"no way through the arena {scenario.name} for the mission {mission!r} in {ATTEMPTS} draws",
        wanted="a drive that meets nothing",
        todo="take another seed_first, or leave the mission out of drives.missions",
    )


def mission_of(recipe: DriveRecipe, number: int) -> MissionName:
    """Return the mission of a drive; evenly spread numbers in 0..1 choose, so that the shares hold in every stretch."""
    names = [name for name in MISSIONS if name in recipe.missions]
    return names[_chosen([recipe.missions[name] for name in names], (number + 0.5) * GOLDEN)]


def behaviour_of(recipe: DriveRecipe, mission: MissionName, number: int) -> Behaviour:
    """Return how a drive is driven, chosen in the same way among what suits its mission."""
    names = [name for name in SUITING[mission] if name in recipe.behaviours]
    return names[_chosen([recipe.behaviours[name] for name in names], (number + 0.5) * ROOT_2)]


def _chosen(shares: Sequence[float], spread: float) -> int:
    """Return which share the fraction of a number falls into."""
    ends = np.cumsum(shares) / sum(shares)
    return min(int(np.searchsorted(ends, spread % 1.0, side="right")), len(shares) - 1)


def _draw_scenario(split: Split, number: int, seed: int, mission: MissionName, rig: SensorRig, draw: int) -> Scenario:
    levels = split.looks.light_levels
    course = COURSE_SETS[split.course]
    return set_up(
        name=f"{split.name}-drive-{number:05d}",
        seed=seed,
        look=draw_look(split.looks, stream(seed, "look"), levels[number % len(levels)]),
        panel_sign="stop",
        layout=_draw_layout(mission, Course(spec=course), stream(seed, "drive", "layout", draw)),
        course=course,
        arena=ArenaSpec(),
        robot=ROBOTS[split.robot],
        rig=rig,
        furniture=split.furniture,
    )


def _draw_layout(mission: MissionName, course: Course, rng: np.random.Generator) -> Layout:
    """Draw the mission's layout; a parking mission's boxes, if it has any, stand where it parks or beside."""
    name = str(rng.choice(LAYOUTS[mission]))
    layout = draw_layout(name, course, rng)
    if name == "random_parking":
        places = course.parking_places[PARKED_IN[mission]]
        while not any(is_in(place, box) for place in places for box in layout.boxes):
            layout = draw_layout(name, course, rng)
    return layout


def _draw_plan(
    recipe: DriveRecipe, scenario: Scenario, mission: MissionName, number: int, attempt: int
) -> DrivePlan | None:
    """Draw a plan; None if there is none, or it would run into something that it means to pass."""
    rng = stream(scenario.seed, "drive", "plan", attempt)
    behaviour = behaviour_of(recipe, mission, number)
    task = Task(
        scenario=scenario,
        behaviour=behaviour,
        cruise_mps=float(rng.uniform(*CRUISE_MPS[mission])),
        lateral_mps2=float(rng.uniform(*LATERAL_MPS2)),
        braking_mps2=float(rng.uniform(*BRAKING_MPS2)),
        care=CARE.get(mission, 1.0),
        duration_s=float(rng.uniform(*recipe.duration_s)),
        rng=rng,
    )
    legs = BUILDERS[mission](task)
    if not legs:
        return None
    start = draw_start(behaviour, _start_pose(legs[0]), rng)
    if not _is_possible(scenario, behaviour, legs, start):
        return None
    hand = draw_hand(behaviour, round(task.duration_s / CONTROL_PERIOD_S), task.care, rng)
    script = DriveScript(
        number=number,
        seed=scenario.seed,
        mission=mission,
        behaviour=behaviour,
        attempt=attempt,
        duration_s=task.duration_s,
        cruise_mps=task.cruise_mps,
        lateral_mps2=task.lateral_mps2,
        delay_steps=hand.delay_steps,
        start_pose=start,
    )
    return DrivePlan(script=script, legs=legs, hand=hand)


def _start_pose(leg: Leg) -> Pose2:
    x_m, y_m, yaw_rad = leg.poses[0].tolist()
    return Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw_rad)


def _is_possible(scenario: Scenario, behaviour: Behaviour, legs: tuple[Leg, ...], start: Pose2) -> bool:
    """Return whether start and lines keep clear of what stands; who means to bump may bump into boxes."""
    bodies = [body for body in scenario.bodies if not (behaviour == "bump" and body.kind == "box")]
    taken = taken_floor(scenario, bodies)
    poses = np.concatenate([np.array([[start.x_m, start.y_m, start.yaw_rad]]), *(leg.poses for leg in legs)])
    return is_free(poses, scenario.robot, taken)
