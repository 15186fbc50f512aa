"""`adc-bench evaluate submission` and `adc-bench rescore`: a submission's score on a suite."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from adc_bench.cli.progress import progress_bar
from adc_bench.cli.result_text import print_result
from adc_bench.errors import UsageError

Engine = Literal["local", "ray"]
Privilege = Literal["pose", "detections"]
AsJson = Annotated[bool, typer.Option("--json", help="Print result.json.")]


def submission(
    submission: Annotated[str, typer.Argument(help="A folder with submission.toml, or a built-in one's name.")],
    suite: Annotated[str, typer.Option(help="A suite's name (splits/suites/NAME.toml) or the path of its file.")],
    out: Annotated[Path, typer.Option(help="The result folder; run again on it to resume.")],
    episodes: Annotated[int | None, typer.Option(min=1, help="Only the suite's first K runs.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a result of another run.")] = False,
    workers: Annotated[int, typer.Option(min=1, help="Runs at a time; the bytes are the same for any number.")] = 1,
    engine: Annotated[
        Engine, typer.Option(help="Processes of this machine, or the Ray cluster that runs (RAY_ADDRESS).")
    ] = "local",
    in_process: Annotated[
        bool, typer.Option("--in-process", help="Without a process of its own: to look into it, never for the board.")
    ] = False,
    record: Annotated[
        bool, typer.Option("--record", help="Make a film of each drive: films/SCENARIO.mp4 (takes as long again).")
    ] = False,
    privileged: Annotated[
        Privilege | None,
        typer.Option(help="Lend a built-in driver the truth in place of a layer, in process: never for the board."),
    ] = None,
    salt_file: Annotated[
        Path | None, typer.Option(help="The secret of a hidden suite; or ADC_BENCH_SALT in the environment.")
    ] = None,
    options: Annotated[list[str] | None, typer.Option("--set", help="KEY=VALUE handed to the submission.")] = None,
    as_json: AsJson = False,
) -> None:
    """Do a suite with a submission of its kind and score it; what the result folder already holds is kept."""
    chosen = parse_options(options or [])
    from adc_bench.evaluate.run import evaluate_submission
    from adc_bench.evaluate.submission import load_submission
    from adc_bench.evaluate.suite import load_suite
    from adc_bench.world.salt import load_salt

    loaded_suite = load_suite(suite)
    loaded = load_submission(submission, chosen, privileged, loaded_suite.kind)
    lent = loaded.id.privileged
    tell_isolation(f"true {lent}" if lent else "--in-process" if in_process else None)
    with progress_bar("running", min(episodes or len(loaded_suite.seeds), len(loaded_suite.seeds))) as tell:
        result = evaluate_submission(
            loaded,
            loaded_suite,
            out,
            episodes=episodes,
            overwrite=overwrite,
            engine=engine,
            workers=workers,
            in_process=in_process,
            record=record,
            salt=load_salt(salt_file),
            tell=tell,
        )
    print_result(result, out, as_json)


def tell_isolation(forgone_by: str | None) -> None:
    """Say on stderr if the submission will not be shut away, because of an option or of the machine."""
    from adc_bench.evaluate.sandbox import sandbox_fault

    fault = forgone_by or sandbox_fault()
    if fault:
        typer.echo(f"note: the submission is not in a sandbox ({fault}); no leaderboard takes the result", err=True)


def rescore(
    out: Annotated[Path, typer.Argument(metavar="DIR", help="The result folder of an `evaluate submission`.")],
    as_json: AsJson = False,
) -> None:
    """Score a result folder again from its logs, without simulating."""
    from adc_bench.evaluate.run import rescore as score_again

    print_result(score_again(out), out, as_json)


def parse_options(texts: list[str]) -> dict[str, str]:
    """Return the options of texts like KEY=VALUE.

    Raises:
        UsageError: a text has no KEY or no =, or a key comes twice.
    """
    options: dict[str, str] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not key or not equals or key in options:
            raise UsageError(
                where="--set",
                found=f"{key!r} twice" if key in options else repr(text),
                wanted="KEY=VALUE, each key once",
                todo="say, for instance, --set weights=FILE",
            )
        options[key] = value
    return options
