"""Suites: which arenas are driven, for how long, and what a submission is told."""

import hashlib

import msgspec

from adc_bench.api import Mission
from adc_bench.errors import InputError
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.geometry import Pose2
from adc_bench.world.look import FLOOR_TEXTURES, LIGHT_SETS, WALL_TEXTURES, LookFamily, draw_look
from adc_bench.world.records import find_record, load_record
from adc_bench.world.robot import draw_robot_truth
from adc_bench.world.scenario import Scenario
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
        InputError: there is no such suite, or its file holds something unusable.
    """
    path = find_record(name_or_path, "splits/suites")
    suite = load_record(path, Suite)
    for found, wanted in _faults(suite):
        raise InputError(where=str(path), found=found, wanted=wanted, todo="mend that key")
    return suite


def _faults(suite: Suite) -> list[tuple[str, str]]:
    """Return what the types cannot say: (found, wanted) for each fault."""
    looks = suite.looks
    named = (
        ("floors", looks.floors, FLOOR_TEXTURES),
        ("walls", looks.walls, WALL_TEXTURES),
        ("light_sets", looks.light_sets, tuple(LIGHT_SETS)),
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
    )
    return faults + [(found, wanted) for good, found, wanted in checks if not good]


def rules_id(suite: Suite, rules: Rules = RULES) -> RulesId:
    """Return the digest of rules and suite together."""
    digest = hashlib.sha256(msgspec.json.encode((rules, suite), order="sorted")).hexdigest()
    return RulesId(id=rules.id, sha256=digest)


def scenario_for(suite: Suite, seed: int, rules: Rules = RULES) -> Scenario:
    """Return the arena of a seed. The suite's light levels take turns over its seeds, so that a few show them all."""
    levels = suite.looks.light_levels
    return Scenario(
        name=suite.scenario_name(seed),
        seed=seed,
        look=draw_look(suite.looks, stream(seed, "look"), levels[suite.seeds.index(seed) % len(levels)]),
        robot_truth=draw_robot_truth(rules.robot, stream(seed, "robot")),
        panel_sign="stop",
        course_spec=rules.course,
        arena_spec=rules.arena,
        robot=rules.robot,
        rig=rules.rig,
    )


def start_step(suite: Suite, seed: int, rules: Rules = RULES) -> int:
    """Return the control step at which the panels turn from stop to the arrow."""
    delay_s = stream(seed, "start").uniform(*suite.start_delay_s)
    return round(delay_s / rules.control_period_s)


def mission_for(suite: Suite, *, latency_s: float, options: dict[str, str], rules: Rules = RULES) -> Mission:
    """Return what a submission is told; the same for every seed."""
    start = Pose2(x_m=rules.start_x_m, y_m=-rules.course.lane_outer_radius_m, yaw_rad=0.0)
    return Mission(
        name=suite.name,
        laps=suite.laps,
        time_limit_s=suite.time_limit_s,
        control_period_s=rules.control_period_s,
        latency_s=latency_s,
        start_pose=start,
        course=rules.course,
        robot=rules.robot,
        rig=rules.rig,
        options=options,
    )
