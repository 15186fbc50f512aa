"""A table of text, for the terminal and for Markdown."""

from collections.abc import Iterator
from typing import NamedTuple


class Table(NamedTuple):
    """A title, the columns' names, rows whose first cell names them, and a sentence on what the figures are."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str


def text_lines(table: Table) -> Iterator[str]:
    """Yield a table as aligned text, its title first."""
    cells = [table.columns, *table.rows]
    widths = [max(len(row[k]) for row in cells) for k in range(len(table.columns))]
    yield table.title
    for row in cells[1 if len(table.columns) == 2 else 0 :]:
        yield (
            "  "
            + "  ".join(
                cell.ljust(width) if k in (0, len(row) - 1) else cell.rjust(width)
                for k, (cell, width) in enumerate(zip(row, widths, strict=True))
            ).rstrip()
        )


def markdown_lines(table: Table) -> Iterator[str]:
    """Yield a table as Markdown, its title and its note first."""
    yield from (f"### {table.title}", "", table.note, "", _bars(table.columns), "|---" * len(table.columns) + "|")
    yield from (_bars(row) for row in table.rows)


def _bars(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"
