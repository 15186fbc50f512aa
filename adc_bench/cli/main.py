"""The command `adc-bench`: its table of commands, and what becomes of an error."""

import errno
import os
import sys
import traceback
from collections.abc import Sequence
from typing import Annotated, NoReturn

import typer

from adc_bench import __version__
from adc_bench.cli.dataset import app as dataset
from adc_bench.cli.doctor import doctor
from adc_bench.cli.evaluate_detector import detector as evaluate_detector
from adc_bench.cli.evaluate_localization import localization as evaluate_localization
from adc_bench.cli.evaluate_submission import rescore
from adc_bench.cli.evaluate_submission import submission as evaluate_submission
from adc_bench.cli.hide import hide
from adc_bench.cli.leaderboard import app as leaderboard
from adc_bench.cli.render import render
from adc_bench.cli.reproduce import app as reproduce
from adc_bench.cli.train_detector import train_detector
from adc_bench.cli.validate import validate
from adc_bench.errors import AdcBenchError, MachineError

app = typer.Typer(
    name="adc-bench",
    help="Datasets and a benchmark for small-scale autonomous driving on the ADC figure-eight course.",
    no_args_is_help=True,
    rich_markup_mode=None,  # plain help shows in half the time
    pretty_exceptions_enable=False,
    add_completion=False,
)
evaluate = typer.Typer(
    help="Score a driver, a localiser or a detector.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

# Of numpy's linear algebra, here and in every process started from here, before it is imported: our matrices are small,
# and threads that wait for each other's share of them take the cores from all that works.
BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "1")
LACKS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EACCES, errno.EPERM, errno.EROFS})
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


app.command()(doctor)
app.command()(render)
app.add_typer(dataset, name="dataset")
app.command("train-detector")(train_detector)
app.add_typer(evaluate, name="evaluate")
evaluate.command("detector")(evaluate_detector)
evaluate.command("localization")(evaluate_localization)
evaluate.command("submission")(evaluate_submission)
app.command()(hide)
app.command()(validate)
app.command()(rescore)
app.add_typer(leaderboard, name="leaderboard")
app.add_typer(reproduce, name="reproduce")


def main(words: Sequence[str] | None = None, commands: typer.Typer = app) -> NoReturn:
    """Run the command line; `--debug` is taken anywhere among the words (default: the process' own).

    Raises:
        SystemExit: always; with 0, or the exit code of the error told on stderr (130 after Ctrl-C).
    """
    given = sys.argv[1:] if words is None else words
    debug = "--debug" in given
    os.environ.setdefault(*BLAS_THREADS)
    try:
        commands(args=[word for word in given if word != "--debug"], prog_name="adc-bench")
    except AdcBenchError as error:
        _fail(error, debug)
    except OSError as error:
        _fail(_lack(error) if error.errno in LACKS else error, debug)
    except Exception as error:  # a fault of ours: one line in place of a traceback, unless asked for
        _fail(error, debug)
    sys.exit(0)


def _lack(error: OSError) -> MachineError:
    return MachineError(
        where=str(error.filename or "a file"),
        found=os.strerror(error.errno or 0).lower(),
        wanted="room and permission to write it",
        todo="make room, or choose another folder",
    )


def _fail(error: Exception, debug: bool) -> NoReturn:
    if debug:
        traceback.print_exc()
    if isinstance(error, AdcBenchError):
        typer.echo(f"error: {HEADLINES[error.exit_code]}\n{error}", err=True)
        sys.exit(error.exit_code)
    typer.echo(f"error: {type(error).__name__}: {error} (a fault of adc-bench; --debug shows where)", err=True)
    sys.exit(1)
