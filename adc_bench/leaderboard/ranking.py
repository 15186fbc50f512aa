"""Who is better than whom: entries in order of their mean points, tied where their intervals overlap."""

import hashlib
import itertools
from collections.abc import Sequence

from adc_bench.evaluate.results import to_json
from adc_bench.evaluate.statistics import Statistic, compare
from adc_bench.evaluate.trajectory_error import NeesVerdict, nees_verdict
from adc_bench.leaderboard.records import Entry, Leaderboard, Pair, Standing, SuiteRanking, title


def ranking(entries: Sequence[Entry]) -> Leaderboard:
    """Return the ranking of each suite that has an entry; all entries on a suite are of the same seeds."""
    suites = sorted({entry.result.suite for entry in entries})
    return Leaderboard(suites={suite: _rank([e for e in entries if e.result.suite == suite]) for suite in suites})


def _rank(entries: Sequence[Entry]) -> SuiteRanking:
    ordered = sorted(entries, key=_merit)
    ranked = [entry for entry in ordered if entry.ranked]
    ranks = places([entry.result.summary["points"] for entry in ranked])
    return SuiteRanking(
        rules=ordered[0].result.rules,
        standings=tuple(_standing(entry, rank) for entry, rank in itertools.zip_longest(ordered, ranks)),
        pairs=tuple(_pair(*both) for both in itertools.combinations(ordered, 2)),
    )


def _merit(entry: Entry) -> tuple[bool, float, float, str]:
    summary = entry.result.summary
    return (not entry.ranked, -summary["points"].mean, -summary["driving_score"].mean, entry.name)


def places(figures: Sequence[Statistic]) -> list[int]:
    """Return the places, from 1, of figures that are in order, best first.

    An entry shares the place of the one above it unless its interval lies wholly below that of the first of that
    place; the next place is then its position in the order.
    """
    found: list[int] = []
    for position, figure in enumerate(figures, start=1):
        leads = not found or figure.ci95[1] < figures[found[-1] - 1].ci95[0]
        found.append(position if leads else found[-1])
    return found


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
    found = [episode.localization for episode in entry.result.episodes if episode.localization]
    means = [errors.nees_mean for errors in found if errors.nees_mean is not None]
    return nees_verdict(means) if means else None


def _pair(first: Entry, second: Entry) -> Pair:
    mine, theirs = ({episode.seed: episode.points for episode in e.result.episodes} for e in (first, second))
    names = (title(entry.result.submission) for entry in (first, second))
    return Pair(first=next(names), second=next(names), points=compare(mine, theirs))
