"""Statistics as one picture: a panel for each chart."""

import io
import math
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adc_bench.dataset.stats.chart import Chart
from adc_bench.dataset.stats.collect import Statistics
from adc_bench.dataset.stats.text import headline

COLUMNS = 3
FEWEST_ROWS = 6  # so that two bars do not fill a panel
COLOURS = ("#2f6f9f", "#c9ccd1")
STYLE: Any = {
    "font.size": 8,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "adc-bench",
}


def picture_of(statistics: Statistics) -> bytes:
    """Return the PNG; equal statistics give equal bytes."""
    rows = math.ceil(len(statistics.charts) / COLUMNS)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(13, 2.9 * rows), dpi=110, layout="constrained")
        panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
        for axes, chart in zip(panels, statistics.charts, strict=False):
            _draw(axes, chart)
        for axes in panels[len(statistics.charts) :]:
            axes.set_axis_off()
        figure.suptitle(headline(statistics), fontsize=11)
        stream = io.BytesIO()
        figure.savefig(stream, format="png", metadata={"Software": None})
    return stream.getvalue()


def _draw(axes: Axes, chart: Chart) -> None:
    """Draw ranges as columns side by side, names as bars one below the other."""
    places, before = np.arange(len(chart.rows)), np.zeros(len(chart.rows))
    for (name, counts), colour in zip(chart.series.items(), COLOURS, strict=False):
        if chart.edges:
            axes.bar(places, counts, width=0.94, bottom=before, color=colour, label=name)
        else:
            axes.barh(places, counts, height=0.8, left=before, color=colour, label=name)
        before += counts
    axes.set_title(chart.title, loc="left")
    if chart.edges:
        axes.set_xticks(np.arange(len(chart.edges)) - 0.5, [f"{edge:g}" for edge in chart.edges])
        axes.set(xlabel=chart.axis, ylabel=chart.what)
    else:
        axes.set_yticks(places, chart.rows, fontsize=8 if len(chart.rows) < 15 else 6)
        axes.set_ylim(max(len(chart.rows), FEWEST_ROWS) - 0.5, -0.5)
        axes.set(xlabel=chart.what, ylabel=chart.axis)
    if len(chart.series) > 1:
        axes.legend(frameon=False)
