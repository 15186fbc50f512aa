"""A training run under way: epochs of steps, its state on disk every so often, its weights scored now and then."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from adc_bench.dataset.layout import write_file
from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.decode import TO_BE_SCORED
from adc_bench.detector.evaluation import Evaluation
from adc_bench.detector.files import write_tensors
from adc_bench.detector.model import Network
from adc_bench.detector.predict import Detector, predict_all
from adc_bench.detector.torch_backend import TorchBackend, save_network
from adc_bench.detector.training.batches import Batch, BatchConfig, run_batches, steps_per_epoch
from adc_bench.detector.training.board import Board, NoBoard, TensorBoard
from adc_bench.detector.training.checkpoint import EpochRecord, Progress, load_checkpoint, save_checkpoint
from adc_bench.detector.training.device import Place
from adc_bench.detector.training.learner import LOSSES, NO_LOSSES, Learner
from adc_bench.detector.training.pictures import TrainingPictures
from adc_bench.detector.training.recipe import TrainConfig
from adc_bench.errors import AdcBenchError

WEIGHTS, CHECKPOINT, LOG = "weights.safetensors", "last.safetensors", "log.jsonl"

Told = Callable[[int, int], None]  # steps done, steps in all


@dataclass(kw_only=True)
class Run:
    """A run under way: what learns from what, and how far it is."""

    source: LabelledPictures
    batches: Iterator[Batch]
    validation: LabelledPictures
    out: Path
    place: Place
    learner: Learner
    progress: Progress
    board: Board

    @classmethod
    def begin(
        cls,
        progress: Progress,
        pictures: TrainingPictures,
        validation: LabelledPictures,
        out: Path,
        place: Place,
        *,
        resume: bool,
    ) -> "Run":
        """Return a run at its start, or where its checkpoint in `out` was written."""
        recipe = progress.recipe
        config = batch_config(recipe.train, place)
        learner = Learner(recipe, place, steps_per_epoch(pictures, config) * recipe.train.epochs)
        if resume:
            progress = load_checkpoint(out / CHECKPOINT, progress, learner)
        elif place.is_first:
            save_checkpoint(out / CHECKPOINT, progress, learner)  # a run can be resumed from its first moment on
        return cls(
            source=pictures.source,
            batches=run_batches(pictures, config, recipe.train.epochs, progress.step),
            validation=validation,
            out=out,
            place=place,
            learner=learner,
            progress=progress,
            board=TensorBoard(out, progress.step + 1) if place.is_first else NoBoard(),
        )

    @property
    def config(self) -> TrainConfig:
        """The course of the run."""
        return self.progress.recipe.train

    @property
    def steps(self) -> int:
        """How many steps an epoch has."""
        return self.learner.steps // self.config.epochs

    def train_epoch(self, told: Told) -> None:
        """Do what is left of an epoch."""
        end = (len(self.progress.history) + 1) * self.steps
        for step in range(self.progress.step, end):
            batch = next(self.batches)
            losses, is_finite = self.learner.look(batch)
            if not is_finite:
                raise self._stopped(batch, losses)
            self.learner.learn(step)
            self._advance(losses)
            told(step + 1, self.learner.steps)

    def end_epoch(self) -> None:
        """Score the weights if they are due, and write down what the epoch did."""
        content = self.place.from_first(lambda: msgspec.json.encode(self._record()))
        record = msgspec.json.decode(content, type=EpochRecord)
        history = (*self.progress.history, record)
        self.progress = msgspec.structs.replace(self.progress, history=history, sums=NO_LOSSES)
        if self.place.is_first:
            save_checkpoint(self.out / CHECKPOINT, self.progress, self.learner)
            write_file(self.out / LOG, b"".join(msgspec.json.encode(past) + b"\n" for past in history))

    def _advance(self, losses: Sequence[float]) -> None:
        """Count a step, and save the state if it is time; an epoch's end saves it as well."""
        step = self.progress.step + 1
        sums = tuple(total + loss for total, loss in zip(self.progress.sums, losses, strict=True))
        self.progress = msgspec.structs.replace(self.progress, step=step, sums=sums)
        self.board.show(step, {f"train/{name}": loss for name, loss in zip(LOSSES, losses, strict=True)})
        if self.place.is_first and step % self.config.checkpoint_steps == 0 and step % self.steps:
            save_checkpoint(self.out / CHECKPOINT, self.progress, self.learner)

    def _record(self) -> EpochRecord:
        """Return what the epoch did, the best weights written."""
        epoch = len(self.progress.history)
        losses = {name: total / self.steps for name, total in zip(LOSSES, self.progress.sums, strict=True)}
        score = evaluate(self.learner.average, self.validation).score() if is_validated(self.config, epoch) else None
        if score:
            self.board.show(self.progress.step, {"val/map": score.map, "val/map50": score.map50})
            if score.map >= max(self.progress.maps, default=0.0):
                save_network(self.out / WEIGHTS, self.learner.average)
        return EpochRecord(epoch=epoch, losses=losses, validation=score)

    def _stopped(self, batch: Batch, losses: Sequence[float]) -> AdcBenchError:
        """Write the batch to a file and return the error that names it."""
        path = self.out / f"bad-batch-{self.place.rank}.safetensors"
        tensors = {"pictures": batch.pictures.numpy()}
        for i, truth in enumerate(batch.truths):
            tensors |= {f"{i}.{name}": part.numpy() for name, part in truth._asdict().items()}
        epoch, step = len(self.progress.history), self.progress.step
        ids = [self.source.image_ids[i] for i in batch.indices]
        write_tensors(path, tensors, msgspec.json.encode({"epoch": epoch, "step": step, "image_ids": ids}))
        return AdcBenchError(
            where=f"training, epoch {epoch}, step {step}",
            found=f"a loss of {losses[0]} or a gradient without end; the batch is in {path}",
            wanted="a finite loss and gradient",
            todo="lower train.learning_rate in the recipe, then start in a new --out folder",
        )


def batch_config(config: TrainConfig, place: Place) -> BatchConfig:
    """Return how a run's pictures are shared out."""
    return BatchConfig(
        batch=config.batch,
        empty_share=config.empty_share,
        plain_from=config.epochs - config.plain_epochs,
        rank=place.rank,
        processes=place.processes,
        workers=config.workers,
    )


def is_validated(config: TrainConfig, epoch: int) -> bool:
    """Whether the weights are scored after this epoch (counted from 0)."""
    return (epoch + 1) % config.validate_every == 0 or epoch + 1 == config.epochs


def evaluate(network: Network, validation: LabelledPictures) -> Evaluation:
    """Return the evaluation of a network on labelled pictures."""
    detector = Detector(TorchBackend(network), TO_BE_SCORED)
    return Evaluation(validation, predict_all(detector, validation))
