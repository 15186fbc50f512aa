"""Runs in processes of their own: killed and resumed, and shared by two that `torchrun` starts."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from conftest import QUICK, UNCLIPPED, Some
from numpy.typing import NDArray

from adc_bench.dataset import FrameDataset
from adc_bench.detector.files import read_tensors
from adc_bench.detector.training.batches import run_batches, steps_per_epoch
from adc_bench.detector.training.device import CPU, Place
from adc_bench.detector.training.learner import Learner
from adc_bench.detector.training.pictures import TrainingPictures
from adc_bench.detector.training.run import batch_config
from adc_bench.detector.training.train import train

KILLED = """
import os, signal, sys
from pathlib import Path
from adc_bench.dataset import FrameDataset
from adc_bench.detector.training.train import train
from conftest import QUICK, Some

train_folder, val_folder, out, step = sys.argv[1:]

def told(done, total):
    if done == int(step):
        os.kill(os.getpid(), signal.SIGKILL)

validation = Some(FrameDataset(val_folder), range(8))
train(QUICK, FrameDataset(train_folder), validation, Path(out), told=told)
"""

SHARED = """
import sys
from pathlib import Path
from adc_bench.dataset import FrameDataset
from adc_bench.detector.training.device import take_place
from adc_bench.detector.training.run import Run
from adc_bench.detector.training.train import train
from adc_bench.detector.torch_backend import save_network
from conftest import UNCLIPPED, Some

class Kept(Run):
    def end_epoch(self):
        super().end_epoch()
        epochs, rank = len(self.progress.history), self.place.rank
        save_network(self.out / f"{rank}-{epochs}.safetensors", self.learner.network)

import adc_bench.detector.training.train
adc_bench.detector.training.train.Run = Kept
train_folder, val_folder, out = sys.argv[1:]
validation = Some(FrameDataset(val_folder), range(8))
with take_place("cpu") as place:
    report = train(UNCLIPPED, FrameDataset(train_folder), validation, Path(out), place=place)
assert report.overall.pictures == 8
"""


def _run(*words: str | Path) -> subprocess.CompletedProcess[str]:
    here = Path(__file__).parent
    root = here.parents[1]
    path = os.pathsep.join([str(root), str(here)])
    environment = {**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"}
    return subprocess.run([sys.executable, *map(str, words)], env=environment, capture_output=True, text=True)


def test_a_run_killed_at_any_step_ends_where_an_unbroken_one_does(
    train_folder: Path, val_folder: Path, training: FrameDataset, validation: FrameDataset, tmp_path: Path
) -> None:
    step = int(np.random.default_rng().integers(1, 16))
    few = Some(validation, range(8))
    killed = _run("-c", KILLED, train_folder, val_folder, tmp_path / "killed", str(step))
    assert killed.returncode == -9, killed.stderr
    assert not (tmp_path / "killed" / "metrics.json").exists()
    train(QUICK, training, few, tmp_path / "killed", resume=True)
    train(QUICK, training, few, tmp_path / "whole")
    for name in ("weights.safetensors", "last.safetensors", "log.jsonl", "metrics.json"):
        same = (tmp_path / "killed" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
        assert same, f"{name}, killed at step {step}"


@pytest.fixture(scope="module")
def shared(train_folder: Path, val_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run of two epochs that two processes shared."""
    folder = tmp_path_factory.mktemp("shared")
    (folder / "run.py").write_text(SHARED)
    words = ("-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2", folder / "run.py")
    done = _run(*words, train_folder, val_folder, folder / "out")
    assert done.returncode == 0, done.stderr
    return folder / "out"


def _parameters(shared: Path, rank: int, epochs: int) -> dict[str, NDArray[np.generic]]:
    tensors, _ = read_tensors(shared / f"{rank}-{epochs}.safetensors", what="", todo="")
    return {name: tensor for name, tensor in tensors.items() if "running" not in name}


def test_two_processes_hold_the_same_weights_and_one_writes(shared: Path) -> None:
    first, second = _parameters(shared, 0, 2), _parameters(shared, 1, 2)
    assert first.keys() == second.keys() and len(first) > 50
    assert all(np.array_equal(first[name], second[name]) for name in first)
    assert len((shared / "log.jsonl").read_text().splitlines()) == 2
    assert len(list((shared / "tensorboard").iterdir())) == 1
    assert (shared / "metrics.json").is_file()


def test_two_processes_learn_from_the_mean_of_their_gradients(shared: Path, training: FrameDataset) -> None:
    pictures = TrainingPictures(training, UNCLIPPED.augment, UNCLIPPED.train.seed)
    configs = [batch_config(UNCLIPPED.train, Place(torch.device("cpu"), rank, 2)) for rank in range(2)]
    total = 2 * steps_per_epoch(pictures, configs[0])
    shares = [run_batches(pictures, config, epochs=1) for config in configs]
    learners = [Learner(UNCLIPPED, CPU, total) for _ in range(2)]
    for step, batches in enumerate(zip(*shares, strict=True)):
        for learner, batch in zip(learners, batches, strict=True):
            learner.look(batch)
        for pair in zip(*(learner.network.parameters() for learner in learners), strict=True):
            mean = torch.stack([parameter.grad for parameter in pair]).mean(dim=0)
            for parameter in pair:
                parameter.grad.copy_(mean)
        for learner in learners:
            learner.learn(step)
    found = _parameters(shared, 0, 1)
    for name, value in learners[0].network.named_parameters():
        assert np.allclose(found[name], value.detach().numpy(), atol=2e-5), name
