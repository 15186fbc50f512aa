"""Training: one loop over epochs, from two datasets to a folder with weights and all that was measured of them."""

from pathlib import Path

import msgspec
import torch

from adc_bench.dataset.layout import write_file
from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.evaluation import DetectionReport
from adc_bench.detector.torch_backend import load_network
from adc_bench.detector.training.checkpoint import Progress
from adc_bench.detector.training.data_checks import data_digest
from adc_bench.detector.training.device import CPU, Place
from adc_bench.detector.training.pictures import TrainingPictures
from adc_bench.detector.training.recipe import Recipe
from adc_bench.detector.training.report import write_report
from adc_bench.detector.training.run import WEIGHTS, Run, Told, evaluate
from adc_bench.errors import InputError

METRICS = "metrics.json"


def train(
    recipe: Recipe,
    training: LabelledPictures,
    validation: LabelledPictures,
    out: Path,
    *,
    place: Place = CPU,
    resume: bool = False,
    told: Told = lambda done, total: None,
) -> DetectionReport:
    """Train by the recipe and fill the folder `out`; return the score of the best epoch's weights.

    The same recipe and pictures give the same weights on one CPU, stopped at any step and resumed or not. In a group of
    processes the first one writes, and the losses in the log are those of its share.

    Raises:
        InputError: `out` holds files without `resume`, or no fitting checkpoint with it; a dataset has no boxes, or a
            damaged picture.
        AdcBenchError: the loss or its gradient is no longer finite.
    """
    torch.set_num_threads(recipe.train.threads)
    digest = data_digest(training, validation)
    if not resume:
        place.from_first(lambda: _claim(out))
    pictures = TrainingPictures(training, recipe.augment, recipe.train.seed, recipe.train.cache_bytes)
    start = Progress(recipe=recipe, data_sha256=digest)
    run = Run.begin(start, pictures, validation, out, place, resume=resume)
    try:
        while not run.progress.is_over:
            run.train_epoch(told)
            run.end_epoch()
    finally:
        run.board.close()
    report = place.from_first(lambda: msgspec.json.encode(finish(out, run.progress, validation, place.device)))
    return msgspec.json.decode(report, type=DetectionReport)


def finish(out: Path, progress: Progress, validation: LabelledPictures, device: torch.device) -> DetectionReport:
    """Score the best weights and write the metrics and the figures."""
    evaluation = evaluate(load_network(out / WEIGHTS).to(device), validation)
    report = evaluation.report()
    write_file(out / METRICS, msgspec.json.format(msgspec.json.encode(report)) + b"\n")
    write_report(out, evaluation, report, progress.history)
    return report


def _claim(out: Path) -> bytes:
    """Make sure that nothing lies in a new run's folder; what a broken write left does not count."""
    if out.is_dir() and any(path.suffix != ".tmp" for path in out.iterdir()):
        raise InputError(
            where=str(out),
            found="a folder that holds files",
            wanted="a new or empty folder",
            todo="choose another --out, or go on with the run that is there: --resume",
        )
    return b""
