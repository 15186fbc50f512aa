"""The ranking as a table in Markdown, and the schema of its JSON."""

from collections.abc import Mapping, Sequence

import msgspec

from adc_bench.api import Kind
from adc_bench.evaluate.results import to_json
from adc_bench.evaluate.schemas import unwrapped
from adc_bench.evaluate.statistics import Statistic
from adc_bench.leaderboard.records import Leaderboard, Standing, SuiteRanking, title

POSITION = ("position RMSE [m]", "position_rmse_m", 4)
# Heading, metric of the summary, decimals.
DRIVING = (
    ("points", "points", 1),
    ("driving score", "driving_score", 1),
    ("completion", "completion", 3),
    ("lap time [s]", "lap_time_s", 2),
    POSITION,
    ("line touches", "line_touches", 1),
    ("collisions", "collisions", 1),
)
COLUMNS: Mapping[Kind, Sequence[tuple[str, str, int]]] = {
    "driver": DRIVING,
    "localizer": (
        POSITION,
        ("95th percentile [m]", "position_p95_m", 4),
        ("heading RMSE [rad]", "heading_rmse_rad", 5),
        ("ATE [m]", "ate_rmse_m", 4),
        ("NEES", "nees_mean", 2),
        ("coverage", "coverage", 3),
    ),
    "detector": (
        ("mAP", "map", 3),
        ("AP50", "map50", 3),
        ("precision", "precision", 3),
        ("recall", "recall", 3),
        ("corner error [px]", "corner_error_px", 2),
    ),
}


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
    columns = COLUMNS[ranking.kind]
    head = ["rank", "submission", *(heading for heading, _, _ in columns), "failed runs"]
    rows = (_line(_cells(standing, columns)) for standing in ranking.standings)
    return [_line(head), _line(["---"] * len(head)), *rows]


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cells(standing: Standing, columns: Sequence[tuple[str, str, int]]) -> list[str]:
    figures = [_figure(standing.summary.get(metric), decimals) for _, metric, decimals in columns]
    return [str(standing.rank or "-"), title(standing.submission), *figures, f"{standing.failed} of {standing.runs}"]


def _figure(figure: Statistic | None, decimals: int) -> str:
    if figure is None:
        return "-"
    low, high = figure.ci95
    return f"{figure.mean:.{decimals}f} [{low:.{decimals}f}, {high:.{decimals}f}]"
