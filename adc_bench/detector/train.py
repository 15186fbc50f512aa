"""Training: one loop over epochs; each ends with a score on the validation pictures and a checkpoint."""

import hashlib
import math
from collections.abc import Callable
from pathlib import Path

import msgspec
import torch
from torch import Tensor, nn
from torch.optim import AdamW

from adc_bench.dataset.layout import write_file
from adc_bench.detector.boxes import grid_points
from adc_bench.detector.checkpoint import EpochRecord, Progress, load_checkpoint, save_checkpoint
from adc_bench.detector.data import LabelledPictures, TrainingPictures, epoch_batches, epoch_order
from adc_bench.detector.decode import DecodeConfig
from adc_bench.detector.evaluate import SCORE_MIN, DetectionReport, Evaluation
from adc_bench.detector.loss import Parts, detection_loss
from adc_bench.detector.model import Network, build_network
from adc_bench.detector.predict import Detector, predict_all
from adc_bench.detector.recipe import Recipe, TrainConfig
from adc_bench.detector.report import draw_curves, draw_history, draw_predictions
from adc_bench.detector.torch_backend import TorchBackend, load_network, save_network
from adc_bench.errors import AdcBenchError, InputError
from adc_bench.world.categories import CATEGORIES

WEIGHTS, CHECKPOINT, METRICS, LOG = "weights.safetensors", "last.safetensors", "metrics.json", "log.jsonl"


def train(
    recipe: Recipe,
    training: LabelledPictures,
    validation: LabelledPictures,
    out: Path,
    *,
    device: str = "cpu",
    resume: bool = False,
    told: Callable[[int], None] = lambda done: None,
) -> DetectionReport:
    """Train by the recipe and fill the folder `out`; return the score of the best epoch's weights.

    The same recipe and pictures give the same weights on one CPU, stopped and resumed or not. `told` hears how many
    steps are done.

    Raises:
        InputError: `out` holds files without `resume`, or no fitting checkpoint with it; a dataset has no boxes.
        AdcBenchError: the loss is no longer finite.
    """
    torch.set_num_threads(recipe.train.threads)
    progress = Progress(recipe=recipe, data_sha256=data_digest(training, validation))
    network = build_network(recipe.model, len(CATEGORIES), recipe.train.seed).to(device)
    average = build_network(recipe.model, len(CATEGORIES), recipe.train.seed).to(device).requires_grad_(False)
    optimizer = AdamW(weight_groups(network, recipe.train.weight_decay))
    if resume:
        progress = load_checkpoint(out / CHECKPOINT, progress, network, average, optimizer)
    elif out.is_dir() and any(out.iterdir()):
        raise InputError(
            where=str(out),
            found="a folder that holds files",
            wanted="a new or empty folder",
            todo="choose another --out, or go on with the run that is there: --resume",
        )
    pictures = TrainingPictures(training, recipe.augment, recipe.train.seed, recipe.train.cache_bytes)
    for epoch in range(len(progress.history), recipe.train.epochs):
        losses = train_epoch(recipe, pictures, network, average, optimizer, epoch, told)
        score = evaluate(average, validation).score() if is_validated(recipe.train, epoch) else None
        if score and score.map >= progress.best_map():
            save_network(out / WEIGHTS, average)
        record = EpochRecord(epoch=epoch, validation=score, losses=losses)
        progress = msgspec.structs.replace(progress, history=(*progress.history, record))
        save_checkpoint(out / CHECKPOINT, progress, network, average, optimizer)
        write_file(out / LOG, b"".join(msgspec.json.encode(past) + b"\n" for past in progress.history))
    return finish(out, progress, validation, device)


def train_epoch(
    recipe: Recipe,
    pictures: TrainingPictures,
    network: Network,
    average: Network,
    optimizer: AdamW,
    epoch: int,
    told: Callable[[int], None] = lambda done: None,
) -> dict[str, float]:
    """Train one epoch in place; return the means of the loss and its parts, by name.

    Raises:
        AdcBenchError: the loss is no longer finite.
    """
    config, device = recipe.train, next(network.parameters()).device
    steps = steps_per_epoch(recipe, pictures.source)
    sums = torch.zeros(1 + len(Parts._fields), dtype=torch.float64)
    network.train()
    shown = epoch_batches(
        pictures, batch=config.batch, epoch=epoch, empty_share=config.empty_share, workers=config.workers
    )
    for step, (prepared, truths) in enumerate(shown, start=epoch * steps):
        x = prepared.to(device, memory_format=torch.channels_last)
        points, strides = grid_points(x.shape[2], x.shape[3], device)
        truths = [type(truth)(*(part.to(device) for part in truth)) for truth in truths]
        loss, parts = detection_loss(recipe.loss, network(x), truths, points, strides)
        _check_finite(loss, epoch, step)
        for group in optimizer.param_groups:
            group["lr"] = learning_rate(config, step, steps * config.epochs)
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(network.parameters(), config.gradient_norm_max)
        optimizer.step()
        update_average(average, network, decay=min(config.average_decay, (1 + step) / (10 + step)))
        sums += torch.stack([loss, *parts]).detach().cpu().double()
        told(step + 1)
    return {name: float(total) / steps for name, total in zip(("loss", *Parts._fields), sums, strict=True)}


def steps_per_epoch(recipe: Recipe, training: LabelledPictures) -> int:
    """Return the number of batches in an epoch, the same for each."""
    pictures = TrainingPictures(training, recipe.augment, recipe.train.seed)
    return math.ceil(len(epoch_order(pictures, 0, recipe.train.empty_share)) / recipe.train.batch)


def is_validated(config: TrainConfig, epoch: int) -> bool:
    """Whether the weights are scored after this epoch (counted from 0)."""
    return (epoch + 1) % config.validate_every == 0 or epoch + 1 == config.epochs


def learning_rate(config: TrainConfig, step: int, steps: int) -> float:
    """Return the rate at a step: a straight rise, then a cosine down to a hundredth."""
    rise = min(1.0, (step + 1) / config.warmup_steps)
    fall = 0.01 + 0.99 * (1 + math.cos(math.pi * step / steps)) / 2
    return config.learning_rate * rise * fall


def weight_groups(network: Network, weight_decay: float) -> list[dict[str, object]]:
    """Return the parameters in two groups: kernels, which decay, and biases and normalisation, which do not."""
    kernels = [parameter for parameter in network.parameters() if parameter.ndim > 1]
    others = [parameter for parameter in network.parameters() if parameter.ndim <= 1]
    return [{"params": kernels, "weight_decay": weight_decay}, {"params": others, "weight_decay": 0.0}]


@torch.no_grad()
def update_average(average: Network, network: Network, *, decay: float) -> None:
    """Move the running mean of the weights, and of the normalisation's statistics, towards the network's."""
    for mean, value in zip(average.state_dict().values(), network.state_dict().values(), strict=True):
        if mean.is_floating_point():
            mean.lerp_(value, 1 - decay)
        else:
            mean.copy_(value)


def evaluate(network: Network, validation: LabelledPictures) -> Evaluation:
    """Return the evaluation of a network on labelled pictures."""
    detector = Detector(TorchBackend(network), DecodeConfig(score_min=SCORE_MIN))
    return Evaluation(validation, predict_all(detector, validation))


def finish(out: Path, progress: Progress, validation: LabelledPictures, device: str) -> DetectionReport:
    """Score the best weights and write the metrics and the figures."""
    network = load_network(out / WEIGHTS).to(device)
    evaluation = evaluate(network, validation)
    report = evaluation.report()
    write_file(out / METRICS, msgspec.json.format(msgspec.json.encode(report)) + b"\n")
    draw_history(out / "loss.png", progress.history)
    draw_curves(out / "pr.png", evaluation.curves())
    draw_predictions(out / "predictions.png", validation, evaluation.found)
    return report


def data_digest(training: LabelledPictures, validation: LabelledPictures) -> str:
    """Return a digest of both sets' labels.

    Raises:
        InputError: a set has no boxes, or fewer pictures than one.
    """
    digest = hashlib.sha256()
    for option, source in (("--train", training), ("--val", validation)):
        labels = [tuple(source.annotations(i)) for i in range(len(source))]
        if all(label.ignore for picture in labels for label in picture):
            raise InputError(
                where=f"the dataset of {option}",
                found=f"{len(source)} pictures without a single box",
                wanted="pictures with labelled objects",
                todo="render more frames: adc-bench render --split NAME --out DIR --frames N",
            )
        digest.update(msgspec.json.encode(labels))
    return digest.hexdigest()


def _check_finite(loss: Tensor, epoch: int, step: int) -> None:
    if not torch.isfinite(loss):
        raise AdcBenchError(
            where=f"training, epoch {epoch}, step {step}",
            found=f"a loss of {loss.item()}",
            wanted="a finite loss",
            todo="lower train.learning_rate in the recipe, then start in a new --out folder",
        )
