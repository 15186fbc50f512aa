"""A run as the site shows it: its trace in metres and seconds, and what is told of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.evaluate.events import Event
from adc_bench.evaluate.localization_score import LocalizationEpisode
from adc_bench.evaluate.score import Episode
from adc_bench.evaluate.suite import AnySuite, rules_for
from adc_bench.leaderboard.traces import MICRO, MILLI, Trace
from adc_bench.world.robot import RobotParams

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class RunData:
    """One run: `times_s` (n,), true poses `truth` (n, 3), `error` (n, 3) of the estimates as seen from the robot
    (ahead, left, turned left) and `sd` (n, 3) of the same; none where the submission gave none.
    """

    suite: AnySuite
    episode: Episode | LocalizationEpisode
    trace: Trace
    times_s: Array
    truth: Array
    error: Array | None
    sd: Array | None

    @property
    def scenario(self) -> str:
        """The run's name."""
        return self.episode.scenario

    @property
    def choice(self) -> str:
        """The run and what came of it, in words."""
        if isinstance(self.episode, Episode):
            return f"{self.scenario}: {self.outcome}, {self.episode.points:.1f} points"
        errors = self.episode.localization
        return f"{self.scenario}: {self.outcome}" + (f", {errors.position_rmse_m:.4f} m" if errors else "")

    @property
    def seed(self) -> int:
        """The seed of the run's arena."""
        return self.episode.seed

    @property
    def robot(self) -> RobotParams:
        """The nominal robot."""
        return rules_for(self.suite).robot

    @property
    def truth_m(self) -> Array:
        """The driven path (n, 2)."""
        return self.truth[:, :2]

    @property
    def estimate_m(self) -> Array | None:
        """The path of the estimates (n, 2)."""
        if self.error is None:
            return None
        cos, sin = np.cos(self.truth[:, 2]), np.sin(self.truth[:, 2])
        ahead, left = self.error[:, 0], self.error[:, 1]
        return self.truth_m + np.stack([cos * ahead - sin * left, sin * ahead + cos * left], axis=1)

    @property
    def faults(self) -> Sequence[tuple[tuple[float, float], str]]:
        """Where the faults happened, and which."""
        return [
            (self.place_m(event), f"{event.time_s:.2f} s: {event.text}")
            for event in self.trace.events
            if event.kind == "fault"
        ]

    def place_m(self, event: Event) -> tuple[float, float]:
        """Return where the robot was at an event."""
        x, y = (float(np.interp(event.time_s, self.times_s, column)) for column in self.truth_m.T)
        return x, y

    @property
    def outcome(self) -> str:
        """How the run ended, in words."""
        return f"{self.episode.reason.replace('-', ' ')} after {self.episode.sim_time_s:.1f} s"

    @property
    def told(self) -> str:
        """What the run's map shows, in words."""
        faults = len(self.faults)
        return (
            f"Run {self.episode.scenario} from above: {self.episode.distance_m:.1f} m driven, {self.outcome}, "
            f"{faults or 'no'} fault{'' if faults == 1 else 's'}"
        )


def run_data(suite: AnySuite, episode: Episode | LocalizationEpisode, trace: Trace) -> RunData:
    """Return a run's data in SI units."""
    count = len(trace.x_mm)
    estimate = trace.estimate
    sds = estimate and (estimate.sd_ahead_um, estimate.sd_left_um, estimate.sd_turn_urad)
    return RunData(
        suite=suite,
        episode=episode,
        trace=trace,
        times_s=np.minimum(np.arange(count) * trace.period_s, trace.end_s),
        truth=_units((trace.x_mm, trace.y_mm, trace.yaw_mrad), MILLI),
        error=_units((estimate.ahead_um, estimate.left_um, estimate.turn_urad), MICRO) if estimate else None,
        sd=_units(sds, MICRO) if sds and None not in sds else None,
    )


def _units(columns: Sequence[Sequence[int] | None], per_unit: float) -> Array:
    return np.array(columns, dtype=np.float64).T / per_unit
