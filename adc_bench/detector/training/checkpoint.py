"""The state of a training run between two steps, in one file: a resumed run goes on as if it had never stopped.

Nothing random is kept: every draw comes from a stream named by seed, epoch and index.
"""

from pathlib import Path

import msgspec
import torch
from torch import Tensor
from torch.optim import Optimizer

from adc_bench.detector.evaluation import DetectionScore
from adc_bench.detector.files import read_tensors, write_tensors
from adc_bench.detector.training.learner import NO_LOSSES, Learner
from adc_bench.detector.training.recipe import Recipe
from adc_bench.errors import InputError

WHAT = "the checkpoint of a run with this recipe and these data"
TODO = "use a new --out folder without --resume"


class EpochRecord(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What one epoch did: the means of the training loss and its parts, and the score of the averaged weights on the
    validation pictures, if they were scored.
    """

    epoch: int
    losses: dict[str, float]
    validation: DetectionScore | None


class Progress(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a run is (recipe, digest of its data), the epochs and the steps it has behind it, and the sums of
    `learner.LOSSES` over the epoch's steps so far.
    """

    recipe: Recipe
    data_sha256: str
    step: int = 0
    sums: tuple[float, ...] = NO_LOSSES
    history: tuple[EpochRecord, ...] = ()

    @property
    def maps(self) -> list[float]:
        """The validation scores so far."""
        return [record.validation.map for record in self.history if record.validation]

    @property
    def is_over(self) -> bool:
        """Whether all epochs are done, or the scores have not become better for as long as the recipe waits."""
        config, maps = self.recipe.train, self.maps
        since_best = maps[::-1].index(max(maps)) if maps else 0
        return len(self.history) == config.epochs or (config.patience is not None and since_best >= config.patience)


def save_checkpoint(path: Path, progress: Progress, learner: Learner) -> None:
    """Write the state of a run."""
    tensors = {f"network.{name}": tensor for name, tensor in learner.network.state_dict().items()}
    tensors |= {f"average.{name}": tensor for name, tensor in learner.average.state_dict().items()}
    for index, entry in learner.optimizer.state_dict()["state"].items():
        tensors |= {f"optimizer.{index}.{name}": torch.as_tensor(value) for name, value in entry.items()}
    held = {name: tensor.detach().cpu().numpy() for name, tensor in tensors.items()}
    write_tensors(path, held, msgspec.json.encode(progress))


def load_checkpoint(path: Path, expected: Progress, learner: Learner) -> Progress:
    """Bring the learner to the saved state and return the progress.

    Raises:
        InputError: no checkpoint, a broken one, or one of another recipe or other data than `expected`.
    """
    held, note = read_tensors(path, what=WHAT, todo=TODO)
    try:
        progress = msgspec.json.decode(note, type=Progress)
    except msgspec.DecodeError as error:
        raise _refused(path, f"a note that cannot be read: {error}") from error
    if progress.recipe != expected.recipe:
        raise _refused(path, "a run of another recipe or number of epochs")
    if progress.data_sha256 != expected.data_sha256:
        raise _refused(path, "a run on other data")
    tensors = {name: torch.from_numpy(tensor) for name, tensor in held.items()}
    try:
        learner.network.load_state_dict(_under("network.", tensors))
        learner.average.load_state_dict(_under("average.", tensors))
        _load_optimizer(learner.optimizer, _under("optimizer.", tensors))
    except (RuntimeError, KeyError, IndexError) as error:
        raise _refused(path, f"tensors that do not fit the network: {str(error).splitlines()[-1].strip()}") from error
    return progress


def _load_optimizer(optimizer: Optimizer, tensors: dict[str, Tensor]) -> None:
    parameters = [parameter for group in optimizer.param_groups for parameter in group["params"]]
    entries: dict[int, dict[str, Tensor]] = {}
    for name, tensor in tensors.items():
        index, key = name.split(".", 1)
        like = parameters[int(index)]
        # Files know no memory layout; a moment lies in memory as its parameter does.
        value = tensor.reshape(()) if key == "step" else torch.empty_like(like).copy_(tensor)
        entries.setdefault(int(index), {})[key] = value
    optimizer.load_state_dict({"state": entries, "param_groups": optimizer.state_dict()["param_groups"]})


def _under(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}


def _refused(path: Path, found: str) -> InputError:
    return InputError(where=str(path), found=found, wanted=WHAT, todo=TODO)
