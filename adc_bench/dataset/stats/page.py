"""Statistics as a page that needs nothing beside itself: tables whose rows are bars."""

from html import escape

from adc_bench.dataset.stats.chart import Chart
from adc_bench.dataset.stats.collect import Statistics
from adc_bench.dataset.stats.text import headline
from adc_bench.pages import filled


def page_of(statistics: Statistics) -> bytes:
    """Return the HTML; equal statistics give equal bytes."""
    charts = "\n".join(_table(chart) for chart in statistics.charts)
    title = f"adc-bench dataset: {statistics.split}"
    return filled("adc_bench.dataset.stats", title, headline=escape(headline(statistics)), charts=charts)


def _table(chart: Chart) -> str:
    most = max((*chart.totals, 1))
    several = len(chart.series) > 1
    columns = "".join(f"<th>{escape(name if several else chart.what)}</th>" for name in chart.series)
    rows = "\n".join(_row(chart, k, most) for k in range(len(chart.rows)))
    return (
        f"<section><h2>{escape(chart.title)}</h2><table><thead><tr><th>{escape(chart.axis)}</th>{columns}"
        f'<th class="bar"></th></tr></thead><tbody>\n{rows}\n</tbody></table></section>'
    )


def _row(chart: Chart, k: int, most: int) -> str:
    counts = [series[k] for series in chart.series.values()]
    numbers = "".join(f"<td>{count:,}</td>" for count in counts)
    bars = "".join(f'<i style="width:{100 * count / most:.2f}%"></i>' for count in counts)
    return f'<tr><th>{escape(chart.rows[k])}</th>{numbers}<td class="bar" aria-hidden="true">{bars}</td></tr>'
