"""The ranking as a table in Markdown, and the schema of its JSON."""

from collections.abc import Sequence

import msgspec

from adc_bench.evaluate.results import to_json
from adc_bench.evaluate.schemas import unwrapped
from adc_bench.evaluate.statistics import Statistic
from adc_bench.leaderboard.records import Leaderboard, Standing, SuiteRanking, title

# Heading, metric of the summary, decimals.
COLUMNS = (
    ("points", "points", 1),
    ("driving score", "driving_score", 1),
    ("completion", "completion", 3),
    ("lap time [s]", "lap_time_s", 2),
    ("position RMSE [m]", "position_rmse_m", 4),
    ("line touches", "line_touches", 1),
    ("collisions", "collisions", 1),
)


def schema() -> bytes:
    """Return the JSON Schema of `leaderboard.json`."""
    return to_json(unwrapped(msgspec.json.schema(Leaderboard)))


def table(board: Leaderboard) -> bytes:
    """Return the ranking as Markdown, one table a suite."""
    lines = [
        "# Leaderboard",
        "",
        "Means over a suite's runs, with the 95 % bootstrap interval of the mean. Entries whose",
    ]
    lines += ["intervals of points overlap share a place.", ""]
    lines += ["Written by `adc-bench leaderboard add DIR`; do not edit.", ""]
    for suite, ranking in board.suites.items():
        lines += [f"## {suite}", "", *_table(ranking)]
        lines += ["", f"Rules `{ranking.rules.id}` `{ranking.rules.sha256[:12]}`.", ""]
    return "\n".join(lines).rstrip().encode() + b"\n"


def _table(ranking: SuiteRanking) -> list[str]:
    head = ["rank", "submission", *(heading for heading, _, _ in COLUMNS), "failed runs"]
    return [_line(head), _line(["---"] * len(head)), *(_line(_cells(standing)) for standing in ranking.standings)]


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cells(standing: Standing) -> list[str]:
    figures = [_figure(standing.summary.get(metric), decimals) for _, metric, decimals in COLUMNS]
    return [str(standing.rank or "-"), title(standing.submission), *figures, f"{standing.failed} of {standing.runs}"]


def _figure(figure: Statistic | None, decimals: int) -> str:
    if figure is None:
        return "-"
    low, high = figure.ci95
    return f"{figure.mean:.{decimals}f} [{low:.{decimals}f}, {high:.{decimals}f}]"
