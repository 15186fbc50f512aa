"""Errors against time with the estimate's own two-sigma band, and the events on a time line: SVG that stretches.

The drawings have no text: labels are HTML beside them, so that they keep their size on a phone.
"""

import math
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from adc_bench.leaderboard.site.run_data import RunData

Array = NDArray[np.float64]
SIGMAS = 2.0
TICKS_MOST = 6
POINTS_MOST = 400  # of a line: a chart is about as many pixels wide, and three of them stand in each run


@dataclass(frozen=True, kw_only=True)
class Panel:
    """What one chart shows: a column of errors, in a unit for people."""

    title: str
    column: int
    unit: str
    per_si: float
    least: float  # half the chart's height at least, in the unit


PANELS = (
    Panel(title="ahead", column=0, unit="cm", per_si=100.0, least=1.0),
    Panel(title="to the left", column=1, unit="cm", per_si=100.0, least=1.0),
    Panel(title="turned left", column=2, unit="°", per_si=180.0 / math.pi, least=0.5),
)


def charts(run: RunData) -> str:
    """Return a chart for each of the three errors over the time line of events."""
    end_s = max(run.trace.end_s, run.trace.period_s)
    ticks_s = np.arange(0.0, end_s + 1e-9, nice(end_s / TICKS_MOST))
    drawn = "" if run.error is None else "".join(_chart(run, panel, ticks_s, end_s) for panel in PANELS)
    return f'<div class="charts">{drawn}{_time_line(run, end_s)}{_time_axis(ticks_s, end_s)}</div>'


def nice(value: float) -> float:
    """Return the least of 1, 2 or 5 times a power of ten that is not below the value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value * (1 - 1e-9))


def _chart(run: RunData, panel: Panel, ticks_s: Array, end_s: float) -> str:
    assert run.error is not None
    error = run.error[:, panel.column] * panel.per_si
    band = None if run.sd is None else SIGMAS * run.sd[:, panel.column] * panel.per_si
    usual = 0.0 if band is None else 1.2 * float(np.median(band))
    reach = nice(max(float(np.abs(error).max()), usual, panel.least))
    grid = "".join(f'<path class="grid" d="M{tick:g} {-reach:g}V{reach:g}"/>' for tick in ticks_s)
    drawn = "" if band is None else f'<polygon class="band" points="{_band(run.times_s, band)}"/>'
    told = f"Error {panel.title} against time, at most {np.abs(error).max():.1f} {panel.unit}"
    return (
        f'<div class="chart"><div class="scale"><b>{panel.title}</b><span>{reach:g} {panel.unit}</span><span>0</span>'
        f'<span>−{reach:g}</span></div><div class="plot"><svg role="img" aria-label="{escape(told)}" '
        f'preserveAspectRatio="none" viewBox="0 {-reach:g} {end_s:g} {2 * reach:g}">{grid}'
        f'<path class="grid" d="M0 0H{end_s:g}"/>{drawn}<polyline class="error" points="{_line(run.times_s, error)}"/>'
        f'</svg><i class="cursor"></i></div></div>'
    )


def _line(times_s: Array, values: Array) -> str:
    """Return the points of a line, in long runs not all of them; a drawing's y goes down."""
    every = math.ceil(len(times_s) / POINTS_MOST)
    return " ".join(f"{time:g},{-value:.3g}" for time, value in zip(times_s[::every], values[::every], strict=True))


def _band(times_s: Array, half: Array) -> str:
    return f"{_line(times_s, half)} {_line(times_s[::-1], -half[::-1])}"


def _time_line(run: RunData, end_s: float) -> str:
    marks = "".join(
        f'<i class="mark {event.kind}" style="left:{100 * event.time_s / end_s:.2f}%" '
        f'title="{event.time_s:.2f} s: {escape(event.text)}"></i>'
        for event in run.trace.events
    )
    return (
        '<div class="chart line" aria-hidden="true"><div class="scale"><b>events</b></div>'
        f'<div class="plot">{marks}<i class="cursor"></i></div></div>'
    )


def _time_axis(ticks_s: Array, end_s: float) -> str:
    labels = "".join(f'<span style="left:{100 * tick / end_s:.2f}%">{tick:g}</span>' for tick in ticks_s)
    scale = '<div class="scale">time [s]</div>'
    return f'<div class="chart axis" aria-hidden="true">{scale}<div class="plot">{labels}</div></div>'
