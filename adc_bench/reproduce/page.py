"""Tables and figures as one page that needs nothing beside itself."""

from collections.abc import Mapping

from adc_bench.pages import figure, grid, report, table
from adc_bench.pages.drawing import INKS, png
from adc_bench.reproduce.figures import Drawn
from adc_bench.reproduce.tables import Table, Tables

HEADLINE = (
    "The results that the thesis reports, beside those of its methods as they are built here, on the real course and "
    "with the robots of the benchmark's draws."
)


def page_of(tables: Tables, figures: Mapping[str, Drawn], pngs: Mapping[str, bytes]) -> bytes:
    """Return the HTML; `pngs` are the figures as files by their names. Equal inputs give equal bytes."""
    body = (
        "<h2>Tables</h2>",
        grid(_table(one) for one in tables.tables),
        "<h2>Figures</h2>",
        grid(figure(drawn.title, pngs[name], png(drawn.draw, INKS["dark"])) for name, drawn in figures.items()),
    )
    return report("adc-bench: the thesis, driven again", HEADLINE, "\n".join(body))


def figure_text(value: float | str | None) -> str:
    """Return a figure as people read it, with four digits or so."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return f"{value:.0f}" if value == round(value) and abs(value) >= 100 else f"{value:.4g}"


def _table(one: Table) -> str:
    rows = [(row.what, figure_text(row.thesis), figure_text(row.ours), row.unit) for row in one.rows]
    return table(one.title, one.note, ("", "thesis", "ours", ""), rows)
