"""HTML of pages that need nothing beside themselves. Equal inputs give equal bytes."""

import base64
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from string import Template

WIDE_COLUMNS = 6  # from so many on a table takes the whole width


def filled(package: str, title: str, **parts: str) -> bytes:
    """Return the `page.html` of a package: `$head` is that of all pages, `$title` the title, the rest its own parts."""
    head = _template("adc_bench.pages", "head.html").substitute(title=escape(title))
    return _template(package, "page.html").substitute(parts, head=head, title=escape(title)).encode()


def report(title: str, headline: str, body: str) -> bytes:
    """Return a page of tables and figures: a title, a sentence below it, and what `grid` and the like make."""
    return filled("adc_bench.pages", title, headline=escape(headline), body=body)


def grid(parts: Iterable[str]) -> str:
    """Return tables and figures side by side, as many as there is room for."""
    return "\n".join(('<div class="grid">', *parts, "</div>"))


def figure(title: str, light: bytes, dark: bytes) -> str:
    """Return a figure of two PNGs: the reader's system chooses."""
    name, on_light, on_dark = escape(title), data_url(light, "png"), data_url(dark, "png")
    return (
        f'<figure><h3>{name}</h3><picture><source media="(prefers-color-scheme: dark)" srcset="{on_dark}">'
        f'<img alt="{name}" src="{on_light}"></picture></figure>'
    )


def table(title: str, note: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table whose rows begin with their names, and a sentence on what its figures are."""
    heads = "".join(f"<th>{escape(name)}</th>" for name in columns)
    body = "\n".join(_row(*row) for row in rows)
    wide = ' class="wide"' if len(columns) >= WIDE_COLUMNS else ""
    return (
        f'<section{wide}><h3>{escape(title)}</h3><p class="note">{escape(note)}</p>'
        f"<table><thead><tr>{heads}</tr></thead><tbody>\n{body}\n</tbody></table></section>"
    )


def data_url(content: bytes, kind: str) -> str:
    """Return a picture of a kind, such as `png`, as an address that holds it."""
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"


def _row(name: str, *cells: str) -> str:
    return f"<tr><th>{escape(name)}</th>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>"


def _template(package: str, name: str) -> Template:
    return Template(files(package).joinpath(name).read_text(encoding="utf-8"))
