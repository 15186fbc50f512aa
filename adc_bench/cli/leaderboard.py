"""`adc-bench leaderboard`: add a result, check the entries, export the ranking, write the site."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(help="Rank results.", no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False)
Board = Annotated[Path, typer.Option("--leaderboard", help="The leaderboard's folder.")]
BOARD = Path("leaderboard")


@app.command()
def add(
    result: Annotated[Path, typer.Argument(metavar="DIR", help="The result folder of an `evaluate submission`.")],
    board: Board = BOARD,
    unranked: Annotated[
        bool, typer.Option("--unranked", help="Show it below the others, without a place; it need not be eligible.")
    ] = False,
) -> None:
    """Add a whole result as an entry."""
    from adc_bench import leaderboard

    entry = leaderboard.add(result, board, unranked=unranked)
    from adc_bench.evaluate.summary import RANKED_BY

    name = RANKED_BY[entry.result.submission.kind][0]
    figure = entry.result.summary.get(name)
    typer.echo(f"{board / 'entries' / entry.name}.json: {name} {f'{figure.mean:.4g}' if figure else 'unknown'}")


@app.command()
def check(board: Board = BOARD) -> None:
    """Check every entry and trace, the table, the ranking's JSON and its schema."""
    from adc_bench import leaderboard

    leaderboard.check(board)
    typer.echo(f"{board}: {len(leaderboard.entries_in(board))} entries, all sound")


@app.command()
def export(
    out: Annotated[Path, typer.Option(help="The file to write, JSON.")],
    board: Board = BOARD,
) -> None:
    """Write the ranking as JSON, as it stands in the leaderboard's folder beside its schema, schema.json."""
    from adc_bench import leaderboard
    from adc_bench.dataset.layout import write_file
    from adc_bench.evaluate.results import to_json

    entries = leaderboard.entries_in(board)
    ranked = leaderboard.ranking(entries)
    write_file(out, to_json(ranked))
    typer.echo(f"{out}: {len(entries)} entries on {', '.join(ranked.suites) or 'no suite'}")


@app.command()
def site(
    out: Annotated[Path, typer.Option(help="The folder to write: new, empty, or an older site.")],
    board: Board = BOARD,
) -> None:
    """Write the leaderboard as a static site: open index.html, or put the folder on any web server."""
    from adc_bench import leaderboard

    pages = leaderboard.write_site(board, out)
    typer.echo(f"{out / 'index.html'}: {pages} pages")
