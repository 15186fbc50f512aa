"""The ranking as a table in Markdown, and the schema of its JSON."""

from collections.abc import Iterable, Sequence

import msgspec

from adc_bench.evaluate.results import to_json
from adc_bench.evaluate.schemas import unwrapped
from adc_bench.evaluate.statistics import Statistic
from adc_bench.leaderboard.figures import columns_of, interval, label, shown, unit_of
from adc_bench.leaderboard.records import Leaderboard, Standing, SuiteRanking, title


def schema() -> bytes:
    """Return the JSON Schema of `leaderboard.json`."""
    return to_json(unwrapped(msgspec.json.schema(Leaderboard)))


def table(board: Leaderboard) -> bytes:
    """Return the ranking as Markdown, one table a suite."""
    lines = [
        "# Leaderboard",
        "",
        "Means over a suite's runs, with the 95 % bootstrap interval of the mean. The first figure ranks;",
    ]
    lines += ["entries whose intervals of it overlap share a place.", ""]
    lines += ["Written by `adc-bench leaderboard add DIR`; do not edit.", ""]
    for suite, ranking in board.suites.items():
        lines += [f"## {suite}", "", *_table(ranking)]
        lines += ["", f"Rules `{ranking.rules.id}` `{ranking.rules.sha256[:12]}`.", ""]
    return "\n".join(lines).rstrip().encode() + b"\n"


def _table(ranking: SuiteRanking) -> list[str]:
    columns = columns_of(ranking)
    head = ["rank", "submission", *(_heading(metric, figure) for metric, figure in columns.items()), "failed runs"]
    rows = (_line(_cells(standing, columns)) for standing in ranking.standings)
    return [_line(head), _line(["---"] * len(head)), *rows]


def _heading(metric: str, figure: Statistic) -> str:
    unit = unit_of(metric, figure)
    return f"{label(metric)} [{unit}]" if unit else label(metric)


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cells(standing: Standing, metrics: Iterable[str]) -> list[str]:
    figures = [_figure(metric, standing.summary.get(metric)) for metric in metrics]
    return [str(standing.rank or "-"), title(standing.submission), *figures, f"{standing.failed} of {standing.runs}"]


def _figure(metric: str, figure: Statistic | None) -> str:
    return "-" if figure is None else f"{shown(metric, figure, figure.mean)} {interval(metric, figure)}"
