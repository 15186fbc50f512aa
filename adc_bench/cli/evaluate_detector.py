"""`adc-bench evaluate detector`: average precision of weights on a dataset."""

from pathlib import Path
from typing import Annotated

import typer


def detector(
    weights: Annotated[Path, typer.Argument(help="A weights file of `train-detector`.")],
    data: Annotated[str, typer.Option(help="The dataset to score on: its folder or address.")],
    out: Annotated[Path, typer.Option(help="The JSON file to write.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Score a detector: average precision in all, by category, by light level, in the tunnel."""
    import msgspec

    from adc_bench.cli.progress import progress_bar
    from adc_bench.cli.train_detector import print_score
    from adc_bench.dataset import FrameDataset
    from adc_bench.dataset.layout import write_file
    from adc_bench.detector import Detector
    from adc_bench.detector.decode import DecodeConfig
    from adc_bench.detector.evaluate import SCORE_MIN, Evaluation
    from adc_bench.detector.predict import predict_all

    chosen = Detector.load(weights, config=DecodeConfig(score_min=SCORE_MIN))
    source = FrameDataset(data)
    with progress_bar("detecting", len(source)) as tell:
        found = predict_all(chosen, source, batch=1, told=tell)  # one at a time, as the driver does
    report = Evaluation(source, found).report()
    text = msgspec.json.format(msgspec.json.encode(report)) + b"\n"
    write_file(out, text)
    if as_json:
        typer.echo(text.decode(), nl=False)
        return
    typer.echo(f"{out}: {weights} on {data}")
    print_score(report.overall)
    for kind, parts in (("light", report.light), ("tunnel", report.tunnel)):
        for name, score in parts.items():
            typer.echo(f"  {kind} {name}: {score.pictures} pictures, mAP50-95 {score.map:.3f}, mAP50 {score.map50:.3f}")
