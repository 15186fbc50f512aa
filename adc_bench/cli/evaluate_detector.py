"""`adc-bench evaluate detector`: all that is measured of weights on a dataset."""

from pathlib import Path
from typing import Annotated

import typer


def detector(
    weights: Annotated[Path, typer.Argument(help="A weights file of `train-detector`.")],
    data: Annotated[str, typer.Option(help="The dataset to score on: its folder or address.")],
    out: Annotated[Path, typer.Option(help="The JSON file to write.")],
    page: Annotated[
        Path | None, typer.Option(help="A page (HTML) to write: figures, the worst mistakes, tables.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Score a detector: precision in all and by circumstance, corners, mistakes, calibration."""
    import hashlib

    import msgspec

    from adc_bench.cli.progress import progress_bar
    from adc_bench.dataset import FrameDataset
    from adc_bench.dataset.layout import write_file
    from adc_bench.detector import Detector
    from adc_bench.detector.decode import TO_BE_SCORED
    from adc_bench.detector.evaluation import EvaluatedWeights, Evaluation
    from adc_bench.detector.evaluation.circumstances import CIRCUMSTANCES
    from adc_bench.detector.evaluation.page import page_of
    from adc_bench.detector.evaluation.table import text_lines
    from adc_bench.detector.evaluation.tables import tables
    from adc_bench.detector.predict import predict_all

    chosen = Detector.load(weights, config=TO_BE_SCORED)
    source = FrameDataset(data)
    with progress_bar("detecting", len(source)) as tell:
        found = predict_all(chosen, source, batch=1, told=tell)  # one at a time, as the driver does
    evaluation = Evaluation(source, found)
    with progress_bar("measuring", len(CIRCUMSTANCES)) as tell:
        report = evaluation.report(tell)
    manifest = source.manifest
    result = EvaluatedWeights(
        weights_sha256=hashlib.sha256(weights.read_bytes()).hexdigest(),
        split=manifest.split.name,
        split_sha256=manifest.split_sha256,
        shards_sha256=manifest.shards_sha256,
        **msgspec.structs.asdict(report),
    )
    text = msgspec.json.format(msgspec.json.encode(result)) + b"\n"
    write_file(out, text)
    if page:
        write_file(page, page_of(evaluation, report, f"{weights.name} on the {manifest.split.name} split."))
    if as_json:
        typer.echo(text.decode(), nl=False)
        return
    typer.echo(f"{out}: {weights} on {data}")
    for table in tables(report)[:3]:
        typer.echo("\n".join(text_lines(table)))
