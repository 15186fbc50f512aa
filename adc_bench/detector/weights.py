"""Weights files: what the network learned, with what is needed to build it again."""

from pathlib import Path

import msgspec
import torch

from adc_bench.detector.files import read_tensors, write_tensors
from adc_bench.detector.model import ARCHITECTURE, ModelConfig, Network, build_network
from adc_bench.errors import InputError
from adc_bench.world.categories import CATEGORIES

_WHAT = f"a weights file of architecture {ARCHITECTURE}"
_TODO = "pass the weights.safetensors of a `train-detector` run"


class WeightsNote(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What stands in a weights file beside the tensors."""

    architecture: str
    config: ModelConfig
    categories: tuple[str, ...]


def shipped_weights() -> Path:
    """Return the weights that come with the package."""
    return Path(__file__).parent / "weights" / "adc-n.safetensors"


def save_weights(path: Path, network: Network) -> None:
    """Write a weights file; equal weights give equal bytes."""
    note = WeightsNote(architecture=ARCHITECTURE, config=network.config, categories=CATEGORIES)
    write_tensors(path, network.state_dict(), msgspec.json.encode(note))


def load_weights(path: Path) -> Network:
    """Return the network of a weights file, ready to predict.

    Raises:
        InputError: the file is missing, broken, of another architecture or other categories, or not finite.
    """
    tensors, note_json = read_tensors(path, what=_WHAT, todo=_TODO)
    note = _read_note(path, note_json)
    network = build_network(note.config, len(note.categories))
    try:
        network.load_state_dict(tensors)
    except RuntimeError as error:
        first = str(error).splitlines()[-1].strip()
        raise _refused(path, f"tensors that do not fit the network: {first}") from error
    if not all(bool(torch.isfinite(tensor).all()) for tensor in tensors.values()):
        raise _refused(path, "weights that are not finite numbers")
    return network.eval()


def _read_note(path: Path, note_json: bytes) -> WeightsNote:
    try:
        architecture = msgspec.json.decode(note_json, type=dict[str, object]).get("architecture")
        if architecture != ARCHITECTURE:
            raise _refused(path, f"weights of architecture {architecture}")
        note = msgspec.json.decode(note_json, type=WeightsNote)
    except msgspec.DecodeError as error:
        raise _refused(path, f"a note that cannot be read: {error}") from error
    if note.categories != CATEGORIES:
        raise _refused(path, f"weights for other categories: {', '.join(note.categories)}")
    return note


def _refused(path: Path, found: str) -> InputError:
    return InputError(where=str(path), found=found, wanted=_WHAT, todo=_TODO)
