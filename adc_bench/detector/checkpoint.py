"""The state of a training run between two epochs, in one file: a resumed run goes on as if it had never stopped.

Nothing random is kept: every draw comes from a stream named by seed, epoch and index.
"""

from pathlib import Path

import msgspec
import torch
from torch import Tensor
from torch.optim import Optimizer

from adc_bench.detector.evaluate import DetectionScore
from adc_bench.detector.files import read_tensors, write_tensors
from adc_bench.detector.model import Network
from adc_bench.detector.recipe import Recipe
from adc_bench.errors import InputError


class EpochRecord(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What one epoch did: the means of the training loss and its parts, and the score of the averaged weights on the validation
    pictures, if they were scored.
    """

    epoch: int
    losses: dict[str, float]
    validation: DetectionScore | None


class Progress(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a run is (recipe, digest of its data) and the epochs it has behind it."""

    recipe: Recipe
    data_sha256: str
    history: tuple[EpochRecord, ...] = ()

    def best_map(self) -> float:
        """Return the best validation score so far, 0 if there is none."""
        return max((record.validation.map for record in self.history if record.validation), default=0.0)


def save_checkpoint(path: Path, progress: Progress, network: Network, average: Network, optimizer: Optimizer) -> None:
    """Write the state of a run."""
    tensors = {f"network.{name}": tensor for name, tensor in network.state_dict().items()}
    tensors |= {f"average.{name}": tensor for name, tensor in average.state_dict().items()}
    for index, entry in optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer.{index}.{name}": torch.as_tensor(value) for name, value in entry.items()}
    held = {name: tensor.detach().cpu().numpy() for name, tensor in tensors.items()}
    write_tensors(path, held, msgspec.json.encode(progress))


def load_checkpoint(
    path: Path, expected: Progress, network: Network, average: Network, optimizer: Optimizer
) -> Progress:
    """Bring network, average and optimizer to the saved state and return the progress.

    Raises:
        InputError: no checkpoint, a broken one, or one of another recipe or other data than `expected`.
    """
    what, todo = "the checkpoint of a run with this recipe and these data", "use a new --out folder without --resume"
    held, note = read_tensors(path, what=what, todo=todo)
    tensors = {name: torch.from_numpy(tensor) for name, tensor in held.items()}
    try:
        progress = msgspec.json.decode(note, type=Progress)
    except msgspec.DecodeError as error:
        raise InputError(
            where=str(path), found=f"a note that cannot be read: {error}", wanted=what, todo=todo
        ) from error
    for name in ("recipe", "data_sha256"):
        if getattr(progress, name) != getattr(expected, name):
            found = {"recipe": "a run of another recipe or number of epochs", "data_sha256": "a run on other data"}[
                name
            ]
            raise InputError(where=str(path), found=found, wanted=what, todo=todo)
    network.load_state_dict(_under("network.", tensors))
    average.load_state_dict(_under("average.", tensors))
    _load_optimizer(optimizer, _under("optimizer.", tensors))
    return progress


def _load_optimizer(optimizer: Optimizer, tensors: dict[str, Tensor]) -> None:
    parameters = [parameter for group in optimizer.param_groups for parameter in group["params"]]
    entries: dict[int, dict[str, Tensor]] = {}
    for name, tensor in tensors.items():
        index, key = name.split(".", 1)
        like = parameters[int(index)]
        # Files know no memory layout; a moment lies in memory as its parameter does.
        value = torch.empty_like(like).copy_(tensor) if tensor.shape == like.shape else tensor
        entries.setdefault(int(index), {})[key] = value
    optimizer.load_state_dict({"state": entries, "param_groups": optimizer.state_dict()["param_groups"]})


def _under(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}
