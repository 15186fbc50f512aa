"""The command `adc-bench`: its table of commands, and what becomes of an error."""

import importlib
import sys
import traceback
from typing import Annotated

import typer

from adc_bench import __version__
from adc_bench.errors import AdcBenchError

app = typer.Typer(
    name="adc-bench",
    help="Datasets and a benchmark for small-scale autonomous driving on the ADC figure-eight course.",
    no_args_is_help=True,
    rich_markup_mode=None,  # plain help: a third of the time to show it
    pretty_exceptions_enable=False,
    add_completion=False,
)
evaluate = typer.Typer(
    help="Score a detector or a driver.", no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False
)

HEADLINES = {1: "adc-bench failed", 2: "wrong usage", 3: "bad input", 4: "this machine lacks something"}


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"adc-bench {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Take the options that stand before any command; `main` looks for --debug itself."""


def _command(group: typer.Typer, room: str, name: str, label: str) -> None:
    try:
        module = importlib.import_module(f"adc_bench.cli.{room}")
    except ModuleNotFoundError as error:
        if error.name != f"adc_bench.cli.{room}":
            raise
        return
    thing = getattr(module, name)
    if isinstance(thing, typer.Typer):
        group.add_typer(thing, name=label)
    else:
        group.command(label)(thing)


_command(app, "doctor", "doctor", "doctor")
_command(app, "render", "render", "render")
_command(app, "dataset", "app", "dataset")
_command(app, "train_detector", "train_detector", "train-detector")
_command(evaluate, "evaluate_detector", "detector", "detector")
_command(evaluate, "evaluate_submission", "submission", "submission")
app.add_typer(evaluate, name="evaluate")
_command(app, "evaluate_submission", "rescore", "rescore")
_command(app, "leaderboard", "app", "leaderboard")


def main() -> None:
    """Run the command line; never returns. `--debug` is taken anywhere among the words.

    Raises:
        SystemExit: with 0, or the exit code of the error told on stderr (130 after Ctrl-C).
    """
    words = [word for word in sys.argv[1:] if word != "--debug"]
    debug = len(words) < len(sys.argv) - 1
    try:
        app(args=words, prog_name="adc-bench")
    except AdcBenchError as error:
        _tell(f"error: {HEADLINES[error.exit_code]}\n{error}", debug)
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception as error:  # a fault of ours: one line in place of a traceback, unless asked for
        _tell(f"error: {type(error).__name__}: {error} (a fault of adc-bench; --debug shows where)", debug)
        sys.exit(1)


def _tell(text: str, debug: bool) -> None:
    if debug:
        traceback.print_exc()
    typer.echo(text, err=True)
