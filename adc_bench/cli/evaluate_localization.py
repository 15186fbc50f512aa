"""`adc-bench evaluate localization`: a localiser's errors over the recorded drives of a dataset."""

from pathlib import Path
from typing import Annotated

import typer

from adc_bench.cli.evaluate_submission import parse_options, tell_isolation
from adc_bench.cli.progress import progress_bar
from adc_bench.cli.result_text import print_result


def localization(
    submission: Annotated[str, typer.Argument(help="A folder with submission.toml, or a built-in localiser's name.")],
    data: Annotated[str, typer.Option(help="A dataset of `render --kind drives`: its folder or address.")],
    out: Annotated[Path, typer.Option(help="The JSON file to write, of the form of a suite's result.json.")],
    workers: Annotated[int, typer.Option(min=1, help="Drives at a time; the bytes are the same for any number.")] = 1,
    in_process: Annotated[
        bool, typer.Option("--in-process", help="Without a process of its own: to look into it.")
    ] = False,
    options: Annotated[list[str] | None, typer.Option("--set", help="KEY=VALUE handed to the localiser.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Let a localiser follow every drive of a dataset, and measure its errors."""
    chosen = parse_options(options or [])
    from adc_bench.dataset.drives import DriveDataset
    from adc_bench.dataset.layout import write_file
    from adc_bench.evaluate.results import to_json
    from adc_bench.evaluate.run import evaluate_localization
    from adc_bench.evaluate.submission import load_submission

    drives = DriveDataset(data)
    loaded = load_submission(submission, chosen, kind="localizer")
    tell_isolation("--in-process" if in_process else None)
    with progress_bar("following", len(drives)) as tell:
        result = evaluate_localization(loaded, drives, workers=workers, in_process=in_process, tell=tell)
    write_file(out, to_json(result))
    print_result(result, out, as_json)
