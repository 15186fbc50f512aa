"""`adc-bench train-detector`: weights, metrics and figures from two datasets."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from adc_bench.detector.evaluation import DetectionScore

Device = Literal["auto", "cpu", "cuda"]


def train_detector(
    train: Annotated[str, typer.Option(help="The dataset to learn from: its folder or address.")],
    val: Annotated[str, typer.Option(help="The dataset to choose the best epoch by; nothing is learned from it.")],
    out: Annotated[Path, typer.Option(help="The run's folder: weights, checkpoint, metrics, figures.")],
    epochs: Annotated[int | None, typer.Option(min=1, help="How many epochs; the recipe's if left out.")] = None,
    config: Annotated[str, typer.Option(help="A recipe: demo, n, s, or the path of a TOML file.")] = "demo",
    device: Annotated[Device, typer.Option(help="Where to train; auto takes a GPU if there is one.")] = "auto",
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the run that is in --out.")] = False,
) -> None:
    """Train a detector and score it on the validation pictures; on several GPUs when started by `torchrun`."""
    from adc_bench.cli.progress import progress_bar
    from adc_bench.dataset import FrameDataset
    from adc_bench.detector.training.data_checks import check_classes
    from adc_bench.detector.training.device import take_place
    from adc_bench.detector.training.recipe import load_recipe
    from adc_bench.detector.training.run import WEIGHTS
    from adc_bench.detector.training.train import METRICS
    from adc_bench.detector.training.train import train as train_run

    recipe = load_recipe(config, epochs=epochs)
    with take_place(device) as place:
        training, validation = FrameDataset(train), FrameDataset(val)
        check_classes(training)
        check_classes(validation)
        with progress_bar("training") as tell:
            told = tell if place.is_first else _silent
            report = train_run(recipe, training, validation, out, place=place, resume=resume, told=told)
    if place.is_first:
        typer.echo(f"{out / WEIGHTS}: learned from {len(training)} pictures; scores in {out / METRICS}")
        print_score(report.overall)


def _silent(done: int, total: int) -> None:
    """Tell nothing: one of several processes is enough to show how far they are."""


def print_score(score: "DetectionScore") -> None:
    """Print the means and a row per category."""
    typer.echo(f"  {score.pictures} pictures: mAP50-95 {score.map:.3f}, mAP50 {score.map50:.3f}")
    for name, entry in score.categories.items():
        typer.echo(f"    {name:<14} AP50-95 {entry.ap:.3f}  AP50 {entry.ap50:.3f}  ({entry.objects} objects)")
