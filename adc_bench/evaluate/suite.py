"""Suites: which arenas are driven, for how long, and what a submission is told."""

import hashlib

import msgspec

from adc_bench.api import Mission
from adc_bench.errors import InputError
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.geometry import Pose2
from adc_bench.world.checks import check_start
from adc_bench.world.course import COURSE_SETS, Course, CourseName, CourseSpec
from adc_bench.world.layout import Layout
from adc_bench.world.look import ARTWORKS, FLOOR_TEXTURES, LIGHT_SETS, WALL_TEXTURES, LookFamily, draw_look
from adc_bench.world.records import find_record, load_record
from adc_bench.world.robot import ROBOTS, RobotName
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SemanticCameraSpec
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream


class Suite(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A list of runs: one arena a seed, the same task in each."""

    name: str
    laps: int
    time_limit_s: float  # from the arrow's appearance
    seeds: tuple[int, ...]
    start_delay_s: tuple[float, float]  # the panels show stop for a time drawn in this range
    blocked_after_s: float
    looks: LookFamily
    layout: str = "open"  # a layout file's name or path, or a word of RANDOM_LAYOUTS
    robot: RobotName = "pioneer"
    course: CourseName = "a"
    semantic_camera: bool = False  # tells the objects in view; never in a ranked suite
    ranked: bool = True  # whether its results may stand on the leaderboard

    def scenario_name(self, seed: int) -> str:
        """Return the name of a seed's run."""
        return f"{self.name}-{seed}"


class RulesId(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Names the rules and the suite under which a run was driven; sha256 covers every figure of both."""

    id: str
    sha256: str


def load_suite(name_or_path: str) -> Suite:
    """Return a suite by the name of a shipped one or the path of a TOML file.

    Raises:
        InputError: there is no such suite, its file holds something unusable, or its arena cannot be.
    """
    path = find_record(name_or_path, "splits/suites")
    suite = load_record(path, Suite)
    for found, wanted in _faults(suite):
        raise InputError(where=str(path), found=found, wanted=wanted, todo="mend that key")
    scenario_for(suite, suite.seeds[0])
    return suite


def _faults(suite: Suite) -> list[tuple[str, str]]:
    """Return what the types cannot say: (found, wanted) for each fault."""
    looks = suite.looks
    named = (
        ("floors", looks.floors, FLOOR_TEXTURES),
        ("walls", looks.walls, WALL_TEXTURES),
        ("light_sets", looks.light_sets, tuple(LIGHT_SETS)),
        ("artworks", looks.artworks, ARTWORKS),
    )
    faults = [
        (f"looks.{key} = {list(values)}", f"one or more of {', '.join(known)}")
        for key, values, known in named
        if not values or set(values) - set(known)
    ]
    low, high = suite.start_delay_s
    checks = (
        (suite.laps >= 1, f"laps = {suite.laps}", "at least 1"),
        (suite.time_limit_s > 0, f"time_limit_s = {suite.time_limit_s}", "more than 0"),
        (suite.blocked_after_s > 0, f"blocked_after_s = {suite.blocked_after_s}", "more than 0"),
        (0 <= low <= high, f"start_delay_s = {[low, high]}", "0 <= from <= to"),
        (bool(looks.light_levels), "looks.light_levels = []", "one or more light levels"),
        (len(suite.seeds) > 0, "seeds = []", "one or more seeds"),
        (len(set(suite.seeds)) == len(suite.seeds), "a seed twice", "each seed once"),
        (
            not (suite.semantic_camera and suite.ranked),
            "semantic_camera = true in a ranked suite",
            "ranked = false with a semantic camera",
        ),
    )
    return faults + [(found, wanted) for good, found, wanted in checks if not good]


def rules_for(suite: Suite, rules: Rules = RULES) -> Rules:
    """Return the rules with the course and the robot that the suite names, and its semantic camera if it has one."""
    semantic = SemanticCameraSpec() if suite.semantic_camera else None
    return msgspec.structs.replace(
        rules,
        course=COURSE_SETS[suite.course],
        robot=ROBOTS[suite.robot],
        rig=msgspec.structs.replace(rules.rig, semantic=semantic),
    )


def rules_id(suite: Suite, rules: Rules = RULES) -> RulesId:
    """Return the digest of rules and suite together, with what the suite's names stand for."""
    own = rules_for(suite, rules)
    whole = (own, suite, _layout(suite, suite.seeds[0], own.course))
    return RulesId(id=rules.id, sha256=hashlib.sha256(msgspec.json.encode(whole, order="sorted")).hexdigest())


def scenario_for(suite: Suite, seed: int, rules: Rules = RULES) -> Scenario:
    """Return the arena of a seed. The suite's light levels take turns over its seeds, so that a few show them all.

    Raises:
        InputError: the suite's layout is unknown or broken, or the arena cannot be.
    """
    levels, own = suite.looks.light_levels, rules_for(suite, rules)
    scenario = set_up(
        name=suite.scenario_name(seed),
        seed=seed,
        look=draw_look(suite.looks, stream(seed, "look"), levels[suite.seeds.index(seed) % len(levels)]),
        panel_sign="stop",
        layout=_layout(suite, seed, own.course),
        course=own.course,
        arena=own.arena,
        robot=own.robot,
        rig=own.rig,
    )
    check_start(scenario, _start_pose(own), f"the arena {scenario.name}")
    return scenario


def _start_pose(rules: Rules) -> Pose2:
    return Pose2(x_m=rules.start_x_m, y_m=-rules.course.lane_outer_radius_m, yaw_rad=0.0)


def _layout(suite: Suite, seed: int, course: CourseSpec) -> Layout:
    return draw_layout(suite.layout, Course(spec=course), stream(seed, "layout"))


def start_step(suite: Suite, seed: int, rules: Rules = RULES) -> int:
    """Return the control step at which the panels turn from stop to the arrow."""
    delay_s = stream(seed, "start").uniform(*suite.start_delay_s)
    return round(delay_s / rules.control_period_s)


def mission_for(suite: Suite, *, latency_s: float, options: dict[str, str], rules: Rules = RULES) -> Mission:
    """Return what a submission is told; the same for every seed."""
    own = rules_for(suite, rules)
    return Mission(
        name=suite.name,
        laps=suite.laps,
        time_limit_s=suite.time_limit_s,
        control_period_s=rules.control_period_s,
        latency_s=latency_s,
        start_pose=_start_pose(own),
        course=own.course,
        robot=own.robot,
        rig=own.rig,
        options=options,
    )
