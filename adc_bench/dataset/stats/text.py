"""Statistics as text for a terminal."""

from collections.abc import Iterator

from adc_bench.dataset.stats.chart import Chart
from adc_bench.dataset.stats.collect import Statistics

BAR = 32


def headline(statistics: Statistics) -> str:
    """Return one line: which split, and how much of it."""
    s = statistics
    return (
        f"{s.split} ({s.kind}): {s.frames:,} pictures of {s.width_px}x{s.height_px} from {s.scenarios:,} arenas, "
        f"{s.labels:,} labels, {s.size_bytes / 1e6:,.1f} MB"
    )


def text_of(statistics: Statistics) -> str:
    """Return all of it, a block of lines for each chart."""
    return "\n\n".join([headline(statistics), *("\n".join(_lines(chart)) for chart in statistics.charts)])


def _lines(chart: Chart) -> Iterator[str]:
    several = len(chart.series) > 1
    yield f"{chart.title}: {chart.what} by {chart.axis}" + (f" ({', '.join(chart.series)})" if several else "")
    wide = max(map(len, chart.rows), default=0)
    most = max((*chart.totals, 1))
    for k, (row, total) in enumerate(zip(chart.rows, chart.totals, strict=True)):
        numbers = " + ".join(f"{counts[k]:,}" for counts in chart.series.values()) if several else f"{total:,}"
        yield f"  {row:<{wide}} {numbers:>15}  {'#' * round(BAR * total / most)}"
