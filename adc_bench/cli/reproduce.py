"""`adc-bench reproduce`: published results, driven again."""

from pathlib import Path
from typing import Annotated

import typer

from adc_bench.cli.progress import progress_bar

app = typer.Typer(
    help="Drive published results again.", no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False
)


@app.callback()
def options() -> None:
    """Keep `thesis` a command of its own."""


@app.command()
def thesis(
    out: Annotated[Path, typer.Option(help="The folder for page, figures and tables; run again on it to resume.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print tables.json.")] = False,
) -> None:
    """The thesis' tables and figures, beside ours."""
    from adc_bench.evaluate.results import to_json
    from adc_bench.reproduce import reproduce

    with progress_bar("experiments") as tell:
        tables = reproduce(out, tell=lambda done, total, what: tell(done, total, what))
    if as_json:
        typer.echo(to_json(tables).decode(), nl=False)
        return
    from adc_bench.reproduce.page import figure_text

    for table in tables.tables:
        typer.echo(table.title)
        for row in table.rows:
            unit = f" {row.unit}" if row.unit else ""
            typer.echo(f"  {row.what}: {figure_text(row.ours)}{unit} (thesis: {figure_text(row.thesis)})")
    typer.echo(f"{out / 'index.html'}")
