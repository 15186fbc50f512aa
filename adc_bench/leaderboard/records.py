"""The files of a leaderboard: entries, and the ranking that is made of them."""

from typing import Literal

import msgspec

from adc_bench.api import Kind
from adc_bench.evaluate.agent_side import Isolation
from adc_bench.evaluate.results import Latency, Result
from adc_bench.evaluate.statistics import Comparison, Statistic
from adc_bench.evaluate.submission import SubmissionId
from adc_bench.evaluate.suite import RulesId
from adc_bench.evaluate.trajectory_error import NeesVerdict


class Entry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A submission's result on a suite, as it stands in `entries/<submission>-<suite>.json`; what its runs looked like
    lies in `traces/<submission>-<suite>.jsonl`, whose digest is `traces_sha256` (none for a detector: pictures have no
    path).
    """

    schema: Literal["adc-bench-entry-3"] = "adc-bench-entry-3"
    ranked: bool
    result: Result
    latency: Latency
    isolation: Isolation
    traces_sha256: str | None

    @property
    def name(self) -> str:
        """The name of the entry's files and of its page."""
        return entry_name(self.result.submission, self.result.suite)


def entry_name(submission: SubmissionId, suite: str) -> str:
    """Return the name of an entry's files; a driver with a layer of truth is another than the driver alone."""
    lent = f"+{submission.privileged}" if submission.privileged else ""
    return f"{submission.name}{lent}-{suite}"


def title(submission: SubmissionId) -> str:
    """Return what a submission is called on the board."""
    return f"{submission.name} with true {submission.privileged}" if submission.privileged else submission.name


class Standing(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An entry with its place, from 1; entries outside the competition have none.

    `failed` runs, in which the submission broke as a program, are among the `runs`, worth nothing.
    """

    rank: int | None
    submission: SubmissionId
    software: dict[str, str]
    runs: int
    failed: int
    summary: dict[str, Statistic]
    nees: NeesVerdict | None  # none if the submission gives no covariances
    latency: Latency
    isolation: Isolation
    result_sha256: str


class Pair(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Two submissions, by title, in the figure that ranks them, seed by seed."""

    first: str
    second: str
    difference: Comparison


class SuiteRanking(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A suite's entries, best first, those outside the competition last, by the mean of `ranked_by`; `pairs` compares
    each with all below it.
    """

    kind: Kind
    ranked_by: str
    rules: RulesId
    standings: tuple[Standing, ...]
    pairs: tuple[Pair, ...]


class Leaderboard(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`leaderboard.json`: the ranking of each suite."""

    schema: Literal["adc-bench-leaderboard-3"] = "adc-bench-leaderboard-3"
    suites: dict[str, SuiteRanking]
