"""`adc-bench leaderboard`: add a result, check the entries, export the ranking."""

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
) -> None:
    """Add a whole, eligible result as an entry."""
    from adc_bench import leaderboard

    entry = leaderboard.add(result, board)
    typer.echo(f"{board / 'entries' / entry.file_name}: driving score {entry.summary['driving_score'].mean:.1f}")


@app.command()
def check(board: Board = BOARD) -> None:
    """Check every entry, the schema and the table."""
    from adc_bench import leaderboard

    ranked = leaderboard.check(board)
    typer.echo(f"{board}: {sum(map(len, ranked.suites.values()))} entries, all sound")


@app.command()
def export(
    out: Annotated[Path, typer.Option(help="The file to write, JSON.")],
    board: Board = BOARD,
) -> None:
    """Write the ranking as JSON; its schema is schema.json in the leaderboard's folder."""
    from adc_bench import leaderboard
    from adc_bench.dataset.layout import write_file
    from adc_bench.evaluate.results import to_json

    ranked = leaderboard.ranking(leaderboard.entries_in(board))
    write_file(out, to_json(ranked))
    typer.echo(f"{out}: {sum(map(len, ranked.suites.values()))} entries on {', '.join(ranked.suites) or 'no suite'}")
