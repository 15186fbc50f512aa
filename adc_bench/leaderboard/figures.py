"""Which figures of a result people are shown, and how: their names, units and digits."""

import math
from collections.abc import Mapping

from adc_bench.api import Kind
from adc_bench.evaluate.statistics import Statistic
from adc_bench.leaderboard.records import SuiteRanking

# What is shown of a kind's results; the first figure ranks.
SHOWN: Mapping[Kind, tuple[str, ...]] = {
    "driver": (
        "points",
        "driving_score",
        "completion",
        "lap_time_s",
        "run_time_s",
        "position_rmse_m",
        "line_touches",
        "collisions",
        "vertical_signs_read",
    ),
    "localizer": (
        "position_rmse_m",
        "position_p95_m",
        "heading_rmse_rad",
        "ate_rmse_m",
        "nees_mean",
        "coverage",
        "dead_reckoning_rmse_m",
    ),
    "detector": ("map", "map50", "precision", "recall", "corner_error_px"),
}
WORDS = {"rmse": "RMSE", "ate": "ATE", "rpe": "RPE", "nees": "NEES", "map": "mAP", "map50": "AP50"}
UNITS = ("_mps", "_radps", "_rad", "_px", "_m", "_s")
SHARES = ("completion", "coverage", "map", "map50", "precision", "recall")
DECIMALS = {"m": 4, "rad": 2, "s": 2, "px": 2, "%": 1}


def columns_of(ranking: SuiteRanking) -> dict[str, Statistic]:
    """Return the figures that a suite's entries have, each with one entry's; the time of a run stands only where there
    are no laps.
    """
    filled = {
        metric: next(standing.summary[metric] for standing in ranking.standings if metric in standing.summary)
        for metric in SHOWN[ranking.kind]
        if any(metric in standing.summary for standing in ranking.standings)
    }
    return {metric: figure for metric, figure in filled.items() if metric != "run_time_s" or "lap_time_s" not in filled}


def label(metric: str) -> str:
    """Return a metric's name for people: `position_rmse_m` is position RMSE."""
    stem = next((metric.removesuffix(unit) for unit in UNITS if metric.endswith(unit)), metric)
    return " ".join(WORDS.get(word, word) for word in stem.split("_"))


def unit_of(metric: str, figure: Statistic) -> str:
    """Return the unit that a metric is shown in: shares in %, angles in degrees."""
    return {"rad": "°"}.get(figure.unit, figure.unit) or ("%" if metric in SHARES else "")


def shown(metric: str, figure: Statistic, value: float) -> str:
    """Return a value of a metric in the unit of `unit_of`."""
    unit = unit_of(metric, figure)
    scaled = value * {"%": 100.0, "°": 180.0 / math.pi}.get(unit, 1.0)
    return f"{scaled:.{DECIMALS.get(figure.unit or unit, 1)}f}"


def interval(metric: str, figure: Statistic) -> str:
    """Return the interval of a metric's mean."""
    low, high = (shown(metric, figure, value) for value in figure.ci95)
    return f"[{low}, {high}]"
