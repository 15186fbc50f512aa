"""What a result folder says: result.json from the logs alone, timing.json with all that varies from run to run."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, get_args

import msgspec
import numpy as np

from adc_bench.evaluate.agent_side import Isolation
from adc_bench.evaluate.ending import Status
from adc_bench.evaluate.log import AnyLog
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.statistics import Statistic
from adc_bench.evaluate.submission import SubmissionId
from adc_bench.evaluate.suite import RulesId
from adc_bench.evaluate.summary import AnyEpisode, scores_of, summary_of


class Result(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`result.json`. `status` is success when all planned runs are there; `eligible` for the leaderboard are
    whole ranked suites done as shipped: no options, no layer of truth, no run lost to the simulator.
    """

    schema: Literal["adc-bench-result-1"] = "adc-bench-result-1"
    suite: str
    rules: RulesId
    submission: SubmissionId
    software: dict[str, str]
    status: Status
    eligible: bool
    planned: int
    completed: int
    episodes: tuple[AnyEpisode, ...]
    summary: dict[str, Statistic]


class EpisodeTiming(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Wall times of one run; the agent's are those of its `step` or `detect` calls."""

    wall_s: float
    sim_time_s: float
    wall_per_sim: float
    agent_p50_s: float | None
    agent_p95_s: float | None
    agent_max_s: float | None
    isolation: Isolation


class Latency(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Whether the agent computes as fast as it says: the slowest run's 95th percentile against one control step plus
    the declared latency, after which its command acts.
    """

    declared_s: float
    allowed_s: float
    measured_p95_s: float | None
    verdict: Literal["within", "exceeded", "not measured"]


class Timing(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`timing.json`. `isolation` is that of the run that had the least."""

    schema: Literal["adc-bench-timing-1"] = "adc-bench-timing-1"
    isolation: Isolation
    latency: Latency
    episodes: dict[str, EpisodeTiming]


def result_of(logs: Sequence[AnyLog], planned: int, rules: Rules = RULES) -> Result:
    """Return the result of the runs of one folder, at least one, all with the same run identity."""
    run = logs[0].header.run
    episodes = scores_of(logs, rules)
    complete = len(episodes) == planned
    lost = any(episode.status in ("simulator-error", "host-error") for episode in episodes)
    whole = complete and planned == len(run.suite.seeds)
    return Result(
        suite=run.suite.name,
        rules=run.rules,
        submission=run.submission,
        software=run.software,
        status="success" if complete else "aborted",
        eligible=run.suite.ranked and whole and not lost and _as_shipped(run.submission),
        planned=planned,
        completed=len(episodes),
        episodes=episodes,
        summary=summary_of(run.suite.kind, episodes),
    )


def _as_shipped(submission: SubmissionId) -> bool:
    return not submission.options and submission.privileged is None


def episode_timing(wall_s: float, sim_time_s: float, compute_s: Sequence[float], isolation: Isolation) -> EpisodeTiming:
    """Return the timing of a run from its wall time, its simulated time and the agent's times."""
    p50, p95, longest = np.quantile(compute_s, (0.5, 0.95, 1.0)).tolist() if compute_s else (None, None, None)
    return EpisodeTiming(
        wall_s=wall_s,
        sim_time_s=sim_time_s,
        wall_per_sim=wall_s / max(sim_time_s, 1e-9),
        agent_p50_s=p50,
        agent_p95_s=p95,
        agent_max_s=longest,
        isolation=isolation,
    )


def timing_of(episodes: Mapping[str, EpisodeTiming], declared_s: float, control_period_s: float) -> Timing:
    """Return the timing of a folder, at least one run, with its verdict on the agent's latency."""
    measured = [timing.agent_p95_s for timing in episodes.values() if timing.agent_p95_s is not None]
    slowest_s = max(measured, default=None)
    allowed_s = control_period_s + declared_s
    kept: Literal["within", "exceeded"] = "within" if slowest_s is None or slowest_s <= allowed_s else "exceeded"
    return Timing(
        isolation=min((timing.isolation for timing in episodes.values()), key=get_args(Isolation)[::-1].index),
        latency=Latency(
            declared_s=declared_s,
            allowed_s=allowed_s,
            measured_p95_s=slowest_s,
            verdict="not measured" if slowest_s is None else kept,
        ),
        episodes=dict(episodes),
    )


def to_json(record: Any) -> bytes:
    """Return the record as indented JSON with sorted keys."""
    return msgspec.json.format(msgspec.json.encode(record, order="sorted"), indent=2) + b"\n"
