"""Whole runs: what they leave, the same bytes for the same recipe, learning by heart, and how they go wrong."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest
import torch
from conftest import PLAIN, QUICK, SMALL, Some
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from adc_bench.dataset import FrameDataset
from adc_bench.detector.evaluation import DetectionScore
from adc_bench.detector.files import read_tensors, write_tensors
from adc_bench.detector.model import build_network
from adc_bench.detector.training.batches import BatchConfig, run_batches
from adc_bench.detector.training.board import FOLDER
from adc_bench.detector.training.checkpoint import EpochRecord, Progress
from adc_bench.detector.training.device import CPU
from adc_bench.detector.training.learner import LOSSES, Learner, learning_rate, update_average
from adc_bench.detector.training.pictures import TrainingPictures
from adc_bench.detector.training.recipe import Recipe, TrainConfig
from adc_bench.detector.training.run import evaluate
from adc_bench.detector.training.train import train
from adc_bench.errors import AdcBenchError, InputError
from adc_bench.world.frame import Label

FILES = {
    "weights.safetensors",
    "last.safetensors",
    "metrics.json",
    "log.jsonl",
    "report.html",
    "predictions.png",
}


def _changed(recipe: Recipe, **changes: Any) -> Recipe:
    return msgspec.structs.replace(recipe, train=msgspec.structs.replace(recipe.train, **changes))


@pytest.fixture(scope="module")
def finished(training: FrameDataset, validation: FrameDataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of an uninterrupted run of the quick recipe."""
    torch.set_num_threads(1)
    out = tmp_path_factory.mktemp("runs") / "whole"
    train(QUICK, training, validation, out)
    return out


def test_a_run_leaves_weights_metrics_log_and_report(finished: Path, validation: FrameDataset) -> None:
    assert {path.name for path in finished.iterdir()} == FILES | {FOLDER}
    assert cv2.imread(str(finished / "predictions.png")).max() > 0
    log = [json.loads(line) for line in (finished / "log.jsonl").read_text().splitlines()]
    assert [record["epoch"] for record in log] == [0, 1, 2]
    assert all(tuple(record["losses"]) == LOSSES for record in log)
    assert log[2]["losses"]["loss"] < log[0]["losses"]["loss"]
    metrics = json.loads((finished / "metrics.json").read_text())
    assert metrics["overall"]["pictures"] == len(validation)
    assert log[0]["validation"] is None
    assert metrics["overall"]["map"] == pytest.approx(max(record["validation"]["map"] for record in log[1:]))


def test_the_same_recipe_gives_the_same_bytes(
    finished: Path, training: FrameDataset, validation: FrameDataset, tmp_path: Path
) -> None:
    train(QUICK, training, validation, tmp_path / "again")
    for name in FILES:
        assert (tmp_path / "again" / name).read_bytes() == (finished / name).read_bytes(), name


def test_a_run_broken_anywhere_ends_where_an_unbroken_one_does(
    finished: Path, training: FrameDataset, validation: FrameDataset, tmp_path: Path
) -> None:
    """Broken in the middle of an epoch, between two checkpoints, and then once more."""

    def break_at(step: int) -> Any:
        def told(done: int, total: int) -> None:
            assert total == 15
            if done == step:
                raise KeyboardInterrupt

        return told

    for step, resume in ((3, False), (9, True)):
        with pytest.raises(KeyboardInterrupt):
            train(QUICK, training, validation, tmp_path / "run", resume=resume, told=break_at(step))
        assert not (tmp_path / "run" / "metrics.json").exists()
    train(QUICK, training, validation, tmp_path / "run", resume=True)
    for name in FILES:
        assert (tmp_path / "run" / name).read_bytes() == (finished / name).read_bytes(), name
    scalars = [EventAccumulator(str(run / FOLDER)).Reload() for run in (finished, tmp_path / "run")]
    for name in ("train/loss", "val/map"):
        whole, broken = ([(event.step, event.value) for event in events.Scalars(name)] for events in scalars)
        assert whole == broken
    assert [step for step, _ in whole] == [10, 15]


def test_a_finished_run_resumed_is_finished(finished: Path, training: FrameDataset, validation: FrameDataset) -> None:
    before = (finished / "metrics.json").read_bytes()
    train(QUICK, training, validation, finished, resume=True)
    assert (finished / "metrics.json").read_bytes() == before


def _easy(labels: Sequence[Label]) -> bool:
    sides = [min(x1 - x0, y1 - y0) for x0, y0, x1, y1 in (label.box_px for label in labels if not label.ignore)]
    return bool(sides) and min(sides) >= 8


def test_eight_pictures_can_be_learned_by_heart(training: FrameDataset) -> None:
    handful = Some(training, [i for i in range(len(training)) if _easy(training.annotations(i))][:8])
    assert len(handful) == 8
    config = TrainConfig(epochs=120, batch=8, learning_rate=1e-2, warmup_steps=10, average_decay=0.9)
    learner = Learner(Recipe(train=config, model=SMALL), CPU, config.epochs)
    batches = run_batches(TrainingPictures(handful, PLAIN, 0), BatchConfig(batch=8), config.epochs)
    for step, batch in enumerate(batches):
        learner.look(batch)
        learner.learn(step)
    score = evaluate(learner.average, handful).score()
    assert score.map > 0.95 and score.map50 > 0.99


def test_a_folder_with_files_is_left_alone(
    quick: Recipe, training: FrameDataset, validation: FrameDataset, tmp_path: Path
) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(InputError, match=r"found: +a folder that holds files(.|\n)*--resume"):
        train(quick, training, validation, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


def test_resuming_needs_a_checkpoint_of_this_run(
    finished: Path, quick: Recipe, training: FrameDataset, validation: FrameDataset, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="no such file"):
        train(quick, training, validation, tmp_path, resume=True)
    with pytest.raises(InputError, match="another recipe or number of epochs"):
        train(_changed(quick, epochs=9), training, validation, finished, resume=True)
    with pytest.raises(InputError, match="other data"):
        train(quick, Some(training, range(20)), validation, finished, resume=True)
    last = tmp_path / "last.safetensors"
    last.write_bytes((finished / "last.safetensors").read_bytes()[:5000])
    with pytest.raises(InputError, match="not a whole safetensors file"):
        train(quick, training, validation, tmp_path, resume=True)
    tensors, _ = read_tensors(finished / "last.safetensors", what="", todo="")
    write_tensors(last, tensors, b"{}")
    with pytest.raises(InputError, match="a note that cannot be read"):
        train(quick, training, validation, tmp_path, resume=True)


@pytest.mark.parametrize("name", ["network.backbone.stem.0.0.weight", "optimizer.0.exp_avg"])
def test_a_checkpoint_of_another_size_is_refused(
    finished: Path, quick: Recipe, training: FrameDataset, validation: FrameDataset, tmp_path: Path, name: str
) -> None:
    tensors, note = read_tensors(finished / "last.safetensors", what="", todo="")
    write_tensors(tmp_path / "last.safetensors", tensors | {name: np.zeros((3, 5), np.float32)}, note)
    with pytest.raises(InputError, match=r"last.safetensors\n +found: +tensors that do not fit the network"):
        train(quick, training, validation, tmp_path, resume=True)


def test_a_dataset_without_boxes_is_refused(quick: Recipe, training: FrameDataset, tmp_path: Path) -> None:
    empty = Some(training, [i for i in range(len(training)) if not training.annotations(i)])
    with pytest.raises(InputError, match=r"dataset of --train\n +found: +\d+ pictures without a single box"):
        train(quick, empty, training, tmp_path / "run")
    with pytest.raises(InputError, match=r"dataset of --val\n +found: +0 pictures without"):
        train(quick, training, Some(training, []), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_loss_that_is_no_number_stops_the_run_and_keeps_its_batch(
    quick: Recipe, training: FrameDataset, validation: FrameDataset, tmp_path: Path
) -> None:
    wild = _changed(quick, learning_rate=1e30, warmup_steps=1)
    kept = tmp_path / "run" / "bad-batch-0.safetensors"
    with pytest.raises(AdcBenchError, match=rf"epoch 0, step \d+\n +found: +a loss of .*{kept}") as caught:
        train(wild, training, validation, tmp_path / "run")
    assert caught.value.exit_code == 1
    tensors, note = read_tensors(kept, what="", todo="")
    told = json.loads(note)
    assert told["epoch"] == 0 and f"step {told['step']}" in str(caught.value)
    pictures = TrainingPictures(training, wild.augment, wild.train.seed)
    config = BatchConfig(batch=8, empty_share=wild.train.empty_share, plain_from=2)
    batch = list(run_batches(pictures, config, 1))[told["step"]]
    assert told["image_ids"] == [training.image_ids[i] for i in batch.indices]
    assert np.array_equal(tensors["pictures"], batch.pictures.numpy())
    assert np.array_equal(tensors["3.boxes"], batch.truths[3].boxes.numpy())


def test_the_checkpoint_holds_the_whole_state(finished: Path) -> None:
    tensors, note = read_tensors(finished / "last.safetensors", what="", todo="")
    kinds = {name.split(".")[0] for name in tensors}
    assert kinds == {"network", "average", "optimizer"}
    assert len(msgspec.json.decode(note, type=Progress).history) == 3
    steps = {float(tensor.item()) for name, tensor in tensors.items() if name.endswith(".step")}
    assert steps == {15.0}


def _after(*maps: float | None, patience: int | None) -> Progress:
    """Progress after epochs with these scores; None for an epoch without."""
    scores = [None if one is None else DetectionScore(pictures=1, map=one, map50=one, categories={}) for one in maps]
    history = tuple(EpochRecord(epoch=i, losses={}, validation=score) for i, score in enumerate(scores))
    recipe = Recipe(train=TrainConfig(epochs=9, patience=patience))
    return Progress(recipe=recipe, data_sha256="", history=history)


def test_a_run_ends_when_its_scores_no_longer_become_better() -> None:
    assert not _after(patience=2).is_over
    assert not _after(None, 0.5, None, 0.4, patience=2).is_over
    assert _after(None, 0.5, None, 0.4, 0.3, patience=2).is_over
    assert not _after(0.5, 0.4, 0.6, 0.5, patience=2).is_over
    assert not _after(0.5, 0.4, 0.3, 0.2, 0.1, patience=None).is_over
    assert _after(*[0.5] * 9, patience=None).is_over


def test_the_learning_rate_rises_then_falls() -> None:
    config = TrainConfig(learning_rate=1.0, warmup_steps=10)
    rates = [learning_rate(config, step, 100) for step in range(100)]
    peak = int(np.argmax(rates))
    assert 5 <= peak <= 12 and rates[0] == pytest.approx(0.1, abs=0.01) and rates[-1] < 0.02
    assert (np.diff(rates[:peak]) > 0).all() and (np.diff(rates[peak:]) < 0).all()


def test_the_average_follows_weights_and_statistics() -> None:
    average, network = (build_network(SMALL, 21, seed) for seed in (0, 1))
    before = {name: value.clone() for name, value in average.state_dict().items()}
    update_average(average, network, decay=0.75)
    for name, value in average.state_dict().items():
        if value.is_floating_point():
            assert torch.allclose(value, 0.75 * before[name] + 0.25 * network.state_dict()[name])
