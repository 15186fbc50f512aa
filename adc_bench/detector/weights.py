"""Weights files: what the network learned, with what is needed to build it again."""

from collections.abc import Mapping
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.files import read_tensors, write_tensors
from adc_bench.detector.note import ARCHITECTURE, TODO, WANTED, ModelConfig, WeightsNote, read_note, refused
from adc_bench.world.categories import CATEGORIES

Tensors = dict[str, NDArray[np.float32]]


def shipped_weights() -> Path:
    """Return the weights that come with the package."""
    return Path(__file__).parent / "weights" / "n.safetensors"


def write_weights(path: Path, tensors: Mapping[str, NDArray[np.float32]], config: ModelConfig) -> None:
    """Write a weights file; equal weights give equal bytes."""
    note = WeightsNote(architecture=ARCHITECTURE, config=config, categories=CATEGORIES)
    write_tensors(path, tensors, msgspec.json.encode(note))


def read_weights(path: Path) -> tuple[Tensors, WeightsNote]:
    """Return the tensors of a weights file and its note.

    Raises:
        InputError: the file is missing, broken, of another architecture or other categories, or not finite.
    """
    tensors, note_json = read_tensors(path, what=WANTED, todo=TODO)
    note = read_note(path, note_json)
    found = {name: np.asarray(tensor, np.float32) for name, tensor in tensors.items()}
    if not all(np.isfinite(tensor).all() for tensor in found.values()):
        raise refused(path, "weights that are not finite numbers")
    return found, note
