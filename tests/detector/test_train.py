import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest
import torch
from conftest import PLAIN, SMALL
from numpy.typing import NDArray
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval
from torch.optim import AdamW

import adc_bench.detector.train as train_module
from adc_bench.dataset import FrameDataset, layout
from adc_bench.detector.checkpoint import Progress
from adc_bench.detector.data import TrainingPictures
from adc_bench.detector.evaluate import Evaluation
from adc_bench.detector.files import read_tensors
from adc_bench.detector.model import build_network
from adc_bench.detector.recipe import Recipe, TrainConfig
from adc_bench.detector.train import evaluate, learning_rate, train, train_epoch, update_average, weight_groups
from adc_bench.errors import AdcBenchError, InputError
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Conditions, Detections, Label


class Some:
    """Some pictures of a dataset."""

    def __init__(self, source: FrameDataset, indices: Sequence[int]) -> None:
        self.source, self.indices = source, indices
        self.image_ids = [source.image_ids[i] for i in indices]

    def __len__(self) -> int:
        return len(self.indices)

    def picture(self, index: int) -> NDArray[np.uint8]:
        return self.source.picture(self.indices[index])

    def annotations(self, index: int) -> Sequence[Label]:
        return self.source.annotations(self.indices[index])

    def conditions(self, index: int) -> Conditions:
        return self.source.conditions(self.indices[index])


def _easy(labels: Sequence[Label]) -> bool:
    sides = [min(x1 - x0, y1 - y0) for x0, y0, x1, y1 in (label.box_px for label in labels)]
    return bool(labels) and min(sides) >= 8


def _changed(recipe: Recipe, **changes: Any) -> Recipe:
    return msgspec.structs.replace(recipe, train=msgspec.structs.replace(recipe.train, **changes))


@pytest.fixture(scope="module")
def finished(training: FrameDataset, validation: FrameDataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of an uninterrupted run of the quick recipe."""
    recipe = Recipe(
        train=TrainConfig(threads=1, epochs=3, batch=8, validate_every=2, warmup_steps=4, average_decay=0.9),
        model=SMALL,
    )
    out = tmp_path_factory.mktemp("runs") / "whole"
    train(recipe, training, validation, out)
    return out


def test_a_run_leaves_weights_metrics_log_and_figures(finished: Path, validation: FrameDataset) -> None:
    names = {path.name for path in finished.iterdir()}
    assert names == {
        "weights.safetensors",
        "last.safetensors",
        "metrics.json",
        "log.jsonl",
        "report.html",
        "predictions.png",
    }
    assert cv2.imread(str(finished / "predictions.png")).min() < 255
    log = [json.loads(line) for line in (finished / "log.jsonl").read_text().splitlines()]
    assert [record["epoch"] for record in log] == [0, 1, 2]
    assert log[2]["loss"] < log[0]["loss"]
    metrics = json.loads((finished / "metrics.json").read_text())
    assert metrics["overall"]["pictures"] == len(validation)
    assert log[0]["validation"] is None
    assert metrics["overall"]["map"] == pytest.approx(max(record["validation"]["map"] for record in log[1:]))


def test_the_same_recipe_gives_the_same_bytes(
    finished: Path, quick: Recipe, training: FrameDataset, validation: FrameDataset, tmp_path: Path
) -> None:
    train(quick, training, validation, tmp_path / "again")
    for name in ("weights.safetensors", "last.safetensors", "metrics.json", "log.jsonl", "report.html", "predictions.png"):
        assert (tmp_path / "again" / name).read_bytes() == (finished / name).read_bytes(), name


def test_a_resumed_run_ends_where_an_uninterrupted_one_does(
    finished: Path,
    quick: Recipe,
    training: FrameDataset,
    validation: FrameDataset,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    save = train_module.save_checkpoint

    def save_then_stop(path: Path, progress: Progress, *state: Any) -> None:
        save(path, progress, *state)
        if len(progress.history) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(train_module, "save_checkpoint", save_then_stop)
    with pytest.raises(KeyboardInterrupt):
        train(quick, training, validation, tmp_path / "run")
    monkeypatch.undo()
    assert not (tmp_path / "run" / "metrics.json").exists()
    train(quick, training, validation, tmp_path / "run", resume=True)
    for path in finished.iterdir():
        assert (tmp_path / "run" / path.name).read_bytes() == path.read_bytes(), path.name


def test_a_handful_of_pictures_can_be_learned_by_heart(training: FrameDataset) -> None:
    handful = Some(training, [i for i in range(len(training)) if _easy(training.annotations(i))][:3])
    config = TrainConfig(epochs=200, batch=3, learning_rate=5e-3, warmup_steps=5, average_decay=0.8)
    recipe = Recipe(train=config, model=SMALL, augment=PLAIN)
    network, average = (build_network(SMALL, len(CATEGORIES)) for _ in range(2))
    optimizer = AdamW(weight_groups(network, config.weight_decay))
    pictures = TrainingPictures(handful, PLAIN, 0)
    losses = [train_epoch(recipe, pictures, network, average, optimizer, epoch)[0] for epoch in range(config.epochs)]
    assert losses[-1] < 0.25 * losses[0]
    score = evaluate(average, handful).score()
    assert score.map50 > 0.95 and score.map > 0.7


def test_the_score_is_that_of_pycocotools_on_the_datasets_own_file(validation: FrameDataset) -> None:
    rng = np.random.default_rng(0)
    found, entries = [], []
    for i, image_id in enumerate(validation.image_ids):
        labels = validation.annotations(i)
        boxes = np.array([label.box_px for label in labels]).reshape(-1, 4) + rng.normal(0, 2, (len(labels), 4))
        scores = rng.uniform(0.05, 1, len(labels))
        categories = np.array([label.category_id if rng.random() < 0.8 else 1 for label in labels], dtype=np.int64)
        found.append(Detections(boxes_px=boxes.astype(np.float32), scores=scores, category_ids=categories))
        for (x0, y0, x1, y1), score, category_id in zip(
            found[-1].boxes_px.astype(float), scores, categories, strict=True
        ):
            box = [x0, y0, x1 - x0, y1 - y0]
            entries.append({"image_id": image_id, "category_id": int(category_id), "bbox": box, "score": score})
    truth = COCO(validation.store.path(layout.COCO))
    run = COCOeval(truth, truth.loadRes(entries), "bbox")
    run.evaluate()
    run.accumulate()
    run.summarize()
    score = Evaluation(validation, found).score()
    assert 0.05 < score.map < 0.95
    assert [score.map, score.map50] == pytest.approx(run.stats[:2].tolist(), abs=1e-6)


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
    (tmp_path / "last.safetensors").write_bytes((finished / "last.safetensors").read_bytes()[:5000])
    with pytest.raises(InputError, match="not a whole safetensors file"):
        train(quick, training, validation, tmp_path, resume=True)


def test_a_dataset_without_boxes_is_refused(quick: Recipe, training: FrameDataset, tmp_path: Path) -> None:
    empty = Some(training, [i for i in range(len(training)) if not training.annotations(i)])
    with pytest.raises(InputError, match=r"dataset of --train\n +found: +\d+ pictures without a single box"):
        train(quick, empty, training, tmp_path / "run")
    with pytest.raises(InputError, match="dataset of --val"):
        train(quick, training, empty, tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_loss_that_is_no_number_stops_the_run(
    quick: Recipe, training: FrameDataset, validation: FrameDataset, tmp_path: Path
) -> None:
    wild = _changed(quick, learning_rate=1e30, warmup_steps=1)
    with pytest.raises(AdcBenchError, match=r"epoch 0, step \d+\n +found: +a loss of (nan|inf)") as caught:
        train(wild, training, validation, tmp_path / "run")
    assert caught.value.exit_code == 1


def test_the_checkpoint_holds_the_whole_state(finished: Path) -> None:
    tensors, note = read_tensors(finished / "last.safetensors", what="", todo="")
    kinds = {name.split(".")[0] for name in tensors}
    assert kinds == {"network", "average", "optimizer"}
    assert len(msgspec.json.decode(note, type=Progress).history) == 3
    steps = {float(tensor) for name, tensor in tensors.items() if name.endswith(".step")}
    assert len(steps) == 1


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
