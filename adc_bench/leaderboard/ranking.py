"""Who is better than whom: entries in order of the mean of their kind's figure, tied where their intervals overlap."""

import hashlib
import itertools
import math
from collections.abc import Sequence

from adc_bench.evaluate.localization_score import LocalizationEpisode
from adc_bench.evaluate.results import to_json
from adc_bench.evaluate.score import Episode
from adc_bench.evaluate.statistics import Statistic, compare
from adc_bench.evaluate.summary import METRICS, RANKED_BY
from adc_bench.evaluate.trajectory_error import NeesVerdict, nees_verdict
from adc_bench.leaderboard.records import Entry, Leaderboard, Pair, Standing, SuiteRanking, title


def ranking(entries: Sequence[Entry]) -> Leaderboard:
    """Return the ranking of each suite that has an entry; all entries on a suite are of the same seeds."""
    suites = sorted({entry.result.suite for entry in entries})
    return Leaderboard(suites={suite: _rank([e for e in entries if e.result.suite == suite]) for suite in suites})


def _rank(entries: Sequence[Entry]) -> SuiteRanking:
    ordered = sorted(entries, key=_merit)
    kind = ordered[0].result.submission.kind
    ranked_by = RANKED_BY[kind][0]
    ranks = places([entry.result.summary[ranked_by] for entry in ordered if entry.ranked])
    whole = [entry for entry in ordered if len(_by_seed(entry)) == entry.result.completed]
    return SuiteRanking(
        kind=kind,
        ranked_by=ranked_by,
        rules=ordered[0].result.rules,
        standings=tuple(_standing(entry, rank) for entry, rank in itertools.zip_longest(ordered, ranks)),
        pairs=tuple(_pair(*both) for both in itertools.combinations(whole, 2)),
    )


def _merit(entry: Entry) -> tuple[bool, float, float, str]:
    first, second = (_badness(entry.result.summary.get(name)) for name in RANKED_BY[entry.result.submission.kind])
    return (not entry.ranked, first, second, entry.name)


def _badness(figure: Statistic | None) -> float:
    """Return a figure's mean, turned so that less is better."""
    if figure is None:
        return math.inf
    return -figure.mean if figure.higher_is_better else figure.mean


def places(figures: Sequence[Statistic]) -> list[int]:
    """Return the places, from 1, of figures that are in order, best first.

    An entry shares the place of the one above it unless its interval lies wholly on the worse side of that of the
    first of that place; the next place is then its position in the order.
    """
    found: list[int] = []
    for position, figure in enumerate(figures, start=1):
        leads = not found or _is_worse(figure, figures[found[-1] - 1])
        found.append(position if leads else found[-1])
    return found


def _is_worse(figure: Statistic, other: Statistic) -> bool:
    """Return whether an interval lies wholly on the worse side of another."""
    if figure.higher_is_better:
        return figure.ci95[1] < other.ci95[0]
    return figure.ci95[0] > other.ci95[1]


def _standing(entry: Entry, rank: int | None) -> Standing:
    result = entry.result
    return Standing(
        rank=rank,
        submission=result.submission,
        software=result.software,
        runs=result.completed,
        failed=sum(episode.failed for episode in result.episodes),
        summary=result.summary,
        nees=_nees(entry),
        latency=entry.latency,
        isolation=entry.isolation,
        result_sha256=hashlib.sha256(to_json(result)).hexdigest(),
    )


def _nees(entry: Entry) -> NeesVerdict | None:
    episodes = [e for e in entry.result.episodes if isinstance(e, Episode | LocalizationEpisode)]
    found = [episode.localization for episode in episodes if episode.localization]
    means = [errors.nees_mean for errors in found if errors.nees_mean is not None]
    return nees_verdict(means) if means else None


def _pair(first: Entry, second: Entry) -> Pair:
    mine, theirs = _by_seed(first), _by_seed(second)
    names = (title(entry.result.submission) for entry in (first, second))
    return Pair(first=next(names), second=next(names), difference=compare(mine, theirs))


def _by_seed(entry: Entry) -> dict[int, float]:
    """Return the figure that ranks an entry, of each run that has it."""
    kind = entry.result.submission.kind
    values = METRICS[kind][RANKED_BY[kind][0]].values
    return {e.seed: value for e in entry.result.episodes for value in values(e) if value is not None}
