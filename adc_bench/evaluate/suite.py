"""Suites: which arenas are driven, for how long, and what a submission is told."""

import hashlib
from collections.abc import Mapping
from typing import ClassVar

import msgspec

from adc_bench.api import Element, Kind, Mission
from adc_bench.dataset.split import named_layouts
from adc_bench.errors import InputError
from adc_bench.evaluate.course_progress import LEAD_M
from adc_bench.evaluate.programme import Programme, Trial
from adc_bench.evaluate.recorded_suite import DetectionSuite, LocalizationSuite
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.geometry import Pose2
from adc_bench.world.checks import check_start
from adc_bench.world.course import COURSE_SETS, Course, CourseName, CourseSpec
from adc_bench.world.layout import Layout
from adc_bench.world.look import ARTWORKS, FLOOR_TEXTURES, LIGHT_SETS, WALL_TEXTURES, LookFamily, draw_look
from adc_bench.world.parking import ParkingKind
from adc_bench.world.parking_zones import free_places
from adc_bench.world.records import find_record, load_record
from adc_bench.world.robot import ROBOTS, RobotName
from adc_bench.world.salt import VARIABLE, salt_sha256, salted_seed
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SemanticCameraSpec
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream


class Suite(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="driver"):
    """A list of runs, one arena a seed. The seeds take turns at the trials."""

    kind: ClassVar[Kind] = "driver"
    name: str
    trials: tuple[Trial, ...]
    time_limit_s: float  # from the first order's appearance
    seeds: tuple[int, ...]
    start_delay_s: tuple[float, float]  # the panels show stop for a time drawn in this range
    blocked_after_s: float
    looks: LookFamily
    parking: ParkingKind | None = None  # what the panels' P asks for
    elements: tuple[Element, ...] = ()  # what the trials hold; told to submissions
    start_x_m: float = -0.65  # of the robot in the lane towards +x
    robot: RobotName = "pioneer"
    course: CourseName = "a"
    semantic_camera: bool = False  # tells the objects in view; never in a ranked suite
    ranked: bool = True  # whether its results may stand on the leaderboard
    salt_sha256: str | None = None  # digest of the private salt that a hidden suite's arenas are drawn with

    @property
    def laps(self) -> int:
        """How many laps each trial has."""
        return len(Programme(orders=self.trials[0].orders).half_laps) // 2

    def trial(self, seed: int) -> Trial:
        """Return the trial of a seed."""
        return self.trials[self.seeds.index(seed) % len(self.trials)]

    def drawn_seed(self, seed: int, salt: bytes | None) -> int:
        """Return what a run is drawn from: its seed, in a hidden suite mixed with the salt."""
        if self.salt_sha256 is None:
            return seed
        assert salt is not None, "check_salt comes first"
        return salted_seed(salt, self.name, seed)

    def scenario_name(self, seed: int) -> str:
        """Return the name of a seed's run."""
        return f"{self.name}-{seed}"


AnySuite = Suite | LocalizationSuite | DetectionSuite


class SuiteKind(msgspec.Struct, frozen=True, kw_only=True):
    """What a suite's file says of itself: whom it is for."""

    kind: Kind = "driver"


SUITES: Mapping[Kind, type[AnySuite]] = {
    "driver": Suite,
    "localizer": LocalizationSuite,
    "detector": DetectionSuite,
}


class RulesId(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Names the rules and the suite under which a run was driven; sha256 covers every figure of both."""

    id: str
    sha256: str


def load_suite(name_or_path: str) -> AnySuite:
    """Return a suite by the name of a shipped one or the path of a TOML file; `kind` in it says whom it is for.

    Raises:
        InputError: there is no such suite, its file holds something unusable, or its arena cannot be.
    """
    path = find_record(name_or_path, "splits/suites")
    suite = load_record(path, SUITES[load_record(path, SuiteKind).kind])
    if not isinstance(suite, Suite):
        named_layouts(suite.split)
        return suite
    for found, wanted in _faults(suite):
        raise InputError(where=str(path), found=found, wanted=wanted, todo="mend that key")
    if suite.salt_sha256 is None:
        for seed in suite.seeds[: len(suite.trials)]:
            _check_run(suite, seed, str(path))
    return suite


def check_salt(suite: AnySuite, salt: bytes | None) -> None:
    """Check that a hidden suite is driven with its own salt.

    Raises:
        InputError: there is no salt, or it is another one.
    """
    if suite.salt_sha256 is None or (salt and salt_sha256(salt) == suite.salt_sha256):
        return
    raise InputError(
        where=f"suite {suite.name}",
        found=f"a salt with the digest {salt_sha256(salt)}" if salt else "no salt",
        wanted=f"the one with the digest {suite.salt_sha256}: the suite is hidden",
        todo=f"name its file with --salt-file, or set {VARIABLE}",
    )


def _check_run(suite: Suite, seed: int, where: str) -> None:
    """Check that a seed's arena can be, and holds what the suite says."""
    scenario = scenario_for(suite, seed)
    layout = scenario.layout
    things: dict[Element, object] = {
        "boxes": layout.boxes,
        "tunnel": layout.tunnel,
        "works": layout.works,
        "vertical_signs": scenario.signs,
    }
    untold = [element for element, thing in things.items() if thing and element not in suite.elements]
    if untold:
        found = f"elements = {list(suite.elements)}, and {', '.join(untold)} in the layout {layout.name!r}"
        raise InputError(where=where, found=found, wanted="all that stands on the course", todo="add it to elements")
    if suite.parking and not free_places(scenario.course, layout, suite.parking):
        found = f"no free place in the layout {layout.name!r}"
        raise InputError(where=where, found=found, wanted="a place to park", todo="free one")


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
        (len({len(Programme(orders=trial.orders).half_laps) for trial in suite.trials}) == 1, *_TRIALS),
        (-LEAD_M <= suite.start_x_m < 0, f"start_x_m = {suite.start_x_m}", f"{-LEAD_M} to 0"),
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
    faults += [(found, wanted) for good, found, wanted in checks if not good]
    for trial in suite.trials:
        wanted = Programme(orders=trial.orders).fault(suite.parking)
        if wanted is None and {"left", "right", "stop"} & set(trial.orders) and "orders" not in suite.elements:
            wanted = "orders among the suite's elements"
        if wanted:
            faults.append((f"orders = {list(trial.orders)}", wanted))
    return faults


_TRIALS = ("trials of different lengths, or none", "one or more trials, all with as many half laps")


def rules_for(suite: AnySuite, rules: Rules = RULES) -> Rules:
    """Return the rules with the course and the robot that the suite names, and its semantic camera if it has one."""
    if not isinstance(suite, Suite):
        split = suite.split
        return msgspec.structs.replace(rules, course=COURSE_SETS[split.course], robot=ROBOTS[split.robot])
    semantic = SemanticCameraSpec() if suite.semantic_camera else None
    return msgspec.structs.replace(
        rules,
        course=COURSE_SETS[suite.course],
        robot=ROBOTS[suite.robot],
        rig=msgspec.structs.replace(rules.rig, semantic=semantic),
    )


def rules_id(suite: AnySuite, rules: Rules = RULES) -> RulesId:
    """Return the digest of rules and suite together, with what the suite's names stand for."""
    own = rules_for(suite, rules)
    layouts = _layouts(suite, own.course) if isinstance(suite, Suite) else named_layouts(suite.split)
    whole = (own, suite, layouts)
    return RulesId(id=rules.id, sha256=hashlib.sha256(msgspec.json.encode(whole, order="sorted")).hexdigest())


def _layouts(suite: Suite, course: CourseSpec) -> list[Layout]:
    return [_layout(suite, seed, seed, course) for seed in suite.seeds[: len(suite.trials)]]


def scenario_for(suite: Suite, seed: int, rules: Rules = RULES, salt: bytes | None = None) -> Scenario:
    """Return the arena of a seed. The suite's light levels take turns: a few seeds show them all, and so do the seeds
    of each trial.

    Raises:
        InputError: the suite's layout is unknown or broken, or the arena cannot be.
    """
    levels, own, drawn = suite.looks.light_levels, rules_for(suite, rules), suite.drawn_seed(seed, salt)
    turn = sum(divmod(suite.seeds.index(seed), len(suite.trials)))
    scenario = set_up(
        name=suite.scenario_name(seed),
        seed=drawn,
        look=draw_look(suite.looks, stream(drawn, "look"), levels[turn % len(levels)]),
        panel_sign="stop",
        layout=_layout(suite, seed, drawn, own.course),
        course=own.course,
        arena=own.arena,
        robot=own.robot,
        rig=own.rig,
    )
    check_start(scenario, _start_pose(suite, own), f"the arena {scenario.name}")
    return scenario


def _start_pose(suite: Suite, rules: Rules) -> Pose2:
    return Pose2(x_m=suite.start_x_m, y_m=-rules.course.lane_outer_radius_m, yaw_rad=0.0)


def _layout(suite: Suite, seed: int, drawn: int, course: CourseSpec) -> Layout:
    return draw_layout(suite.trial(seed).layout, Course(spec=course), stream(drawn, "layout"))


def start_step(suite: Suite, seed: int, rules: Rules = RULES, salt: bytes | None = None) -> int:
    """Return the control step at which the panels turn from stop to the first order."""
    delay_s = stream(suite.drawn_seed(seed, salt), "start").uniform(*suite.start_delay_s)
    return round(delay_s / rules.control_period_s)


def mission_for(suite: Suite, *, latency_s: float, options: dict[str, str], rules: Rules = RULES) -> Mission:
    """Return what a submission is told; the same for every seed."""
    own = rules_for(suite, rules)
    return Mission(
        name=suite.name,
        laps=suite.laps,
        parking=suite.parking,
        elements=suite.elements,
        time_limit_s=suite.time_limit_s,
        control_period_s=rules.control_period_s,
        latency_s=latency_s,
        start_pose=_start_pose(suite, own),
        course=own.course,
        robot=own.robot,
        rig=own.rig,
        options=options,
    )
