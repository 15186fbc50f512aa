"""Figures in words and digits for people: labels, units, means with their intervals; and the frame of every page."""

import math
from functools import cache
from html import escape
from importlib.resources import files
from string import Template

from adc_bench.evaluate.statistics import Statistic

WORDS = {"rmse": "RMSE", "ate": "ATE", "rpe": "RPE", "nees": "NEES", "map": "mAP", "map50": "AP50"}
UNITS = ("_mps", "_radps", "_rad", "_px", "_m", "_s")
SHARES = ("completion", "coverage", "map", "map50", "precision", "recall")
DECIMALS = {"m": 4, "rad": 2, "s": 2, "px": 2, "%": 1}
DASH = "–"


def asset(name: str) -> str:
    """Return the text of a file that lies beside this module."""
    return files("adc_bench.leaderboard.site").joinpath(name).read_text(encoding="utf-8")


@cache
def _frame() -> Template:
    return Template(asset("page.html"))


def page(title: str, body: str, *, root: str, script: str) -> bytes:
    """Return a page; `root` leads from it to the site's folder, `script` is the file of its script there."""
    return _frame().substitute(title=escape(title), body=body, root=root, script=script).encode()


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


def plural(count: int, what: str) -> str:
    """Return a count of things in words."""
    return f"{count} {what}{'' if count == 1 else 's'}"
