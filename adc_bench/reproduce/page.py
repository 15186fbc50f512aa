"""Tables and figures as one page that needs nothing beside itself."""

import base64
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from string import Template

from adc_bench.detector.evaluation.figures import INKS, png
from adc_bench.reproduce.figures import Drawn
from adc_bench.reproduce.tables import Row, Table, Tables


def page_of(tables: Tables, figures: Mapping[str, Drawn], pngs: Mapping[str, bytes]) -> bytes:
    """Return the HTML; `pngs` are the figures as files by their names. Equal inputs give equal bytes."""
    template = Template(files("adc_bench.reproduce").joinpath("page.html").read_text(encoding="utf-8"))
    return template.substitute(
        tables="\n".join(_table(table) for table in tables.tables),
        figures="\n".join(_figure(drawn, pngs[name]) for name, drawn in figures.items()),
    ).encode()


def figure_text(value: float | str | None) -> str:
    """Return a figure as people read it, with four digits or so."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return f"{value:.0f}" if value == round(value) and abs(value) >= 100 else f"{value:.4g}"


def _figure(drawn: Drawn, on_white: bytes) -> str:
    light, dark = _data(on_white), _data(png(drawn.draw, INKS["dark"]))
    title = escape(drawn.title)
    return (
        f'<figure><h3>{title}</h3><picture><source media="(prefers-color-scheme: dark)" srcset="{dark}">'
        f'<img alt="{title}" src="{light}"></picture></figure>'
    )


def _table(table: Table) -> str:
    rows = "\n".join(_row(row) for row in table.rows)
    return (
        f'<section><h3>{escape(table.title)}</h3><p class="note">{escape(table.note)}</p>'
        f"<table><thead><tr><th></th><th>thesis</th><th>ours</th><th></th></tr></thead>"
        f"<tbody>\n{rows}\n</tbody></table></section>"
    )


def _row(row: Row) -> str:
    cells = (figure_text(row.thesis), figure_text(row.ours), row.unit)
    return f"<tr><th>{escape(row.what)}</th>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>"


def _data(content: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(content).decode()}"
