"""A lap by the thesis' driver from pixels, with all that its localiser saw."""

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import msgspec

from adc_bench.api import Agent, Mission, Observation
from adc_bench.detector import Detector, shipped_weights
from adc_bench.evaluate.agent_side import Load
from adc_bench.evaluate.driving import software
from adc_bench.evaluate.episode import drive, process_renderer
from adc_bench.evaluate.in_process import InProcessAgent
from adc_bench.evaluate.plans import plan_for
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.run_header import RunId
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import load_suite, rules_id
from adc_bench.reference import Layers, thesis
from adc_bench.reproduce.filters import Estimate, Seen, estimate_of, seen_of
from adc_bench.reproduce.settings import Settings
from adc_bench.stack.ekf import Belief
from adc_bench.stack.localizer import Detect, Localizer, LocalizerState

SUITE = "dev"  # one lap of both loops


@dataclass(frozen=True, kw_only=True)
class Notebook:
    """A localiser that notes what it believes and sees, for one run."""

    localizer: Localizer
    beliefs: list[Belief] = field(default_factory=list)
    seen: list[Seen] = field(default_factory=list)

    def start(self) -> LocalizerState:
        """Return the state at the mission's start pose."""
        return self.localizer.start()

    def step(self, state: LocalizerState, observation: Observation) -> LocalizerState:
        """Return the state at the observation's time."""
        state = self.localizer.step(state, observation)
        self.beliefs.append(state.belief)
        for sighting in state.sightings:
            self.seen.append(seen_of(observation.time_s, sighting.kind, sighting.innovation, state.belief))
        return state


def drive_from_pixels(settings: Settings) -> Estimate:
    """Return the estimate of a lap of the suite `dev` at 1 m/s.

    Raises:
        MachineError: this machine cannot render.
    """
    suite = msgspec.structs.replace(load_suite(SUITE), time_limit_s=settings.pixels_limit_s)
    submission = load_submission("thesis", {})
    renderer = process_renderer(RULES.rig)
    run = RunId(suite=suite, rules=rules_id(suite), submission=submission.id, software=software(renderer.device_name))
    plan = plan_for(run, suite.seeds[0], submission)
    notebooks: list[Notebook] = []
    make = partial(_noting, Detector.load(shipped_weights()), notebooks)
    with InProcessAgent(submission.load, RULES.limits, make) as agent:
        driven = drive(plan, renderer, agent)
    book = notebooks[0]
    rows = driven.rows[: len(book.beliefs)]
    return estimate_of([row.time_s for row in rows], [row.truth for row in rows], book.beliefs, book.seen)


def _noting(detect: Detect, notebooks: list[Notebook], load: Load, folder: Path) -> Agent:
    """Return the thesis' driver with a localiser that takes notes."""

    def localizer(mission: Mission) -> Notebook:
        notebooks.append(Notebook(localizer=Localizer(mission=mission, detect=detect)))
        return notebooks[-1]

    return thesis({}, Layers(detect=detect, localizer=localizer))
