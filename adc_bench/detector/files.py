"""Tensors in files: safetensors with one JSON note, written whole or not at all, never pickled."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from adc_bench.dataset.layout import write_file
from adc_bench.detector.note import NOTE
from adc_bench.errors import InputError

Tensors = dict[str, NDArray[np.generic]]


def write_tensors(path: Path, tensors: Mapping[str, NDArray[np.generic]], note: bytes) -> None:
    """Write tensors and a JSON note; equal content gives equal bytes."""
    held = {name: np.ascontiguousarray(tensors[name]) for name in sorted(tensors)}
    write_file(path, save(held, metadata={NOTE: note.decode()}))


def read_tensors(path: Path, *, what: str, todo: str) -> tuple[Tensors, bytes]:
    """Return the tensors and the note.

    Raises:
        InputError: no such file, or not a whole safetensors file of this project; `what` and `todo` word it.
    """
    if not path.is_file():
        raise InputError(where=str(path), found="no such file", wanted=what, todo=todo)
    try:
        with safe_open(path, framework="np") as content:
            note = (content.metadata() or {}).get(NOTE)
            tensors = {name: content.get_tensor(name) for name in content.keys()}  # noqa: SIM118 - not a mapping
    except SafetensorError as error:
        found = f"not a whole safetensors file ({error})"
        raise InputError(where=str(path), found=found, wanted=what, todo=todo) from error
    if note is None:
        raise InputError(
            where=str(path), found="a safetensors file without this project's note", wanted=what, todo=todo
        )
    return tensors, note.encode()
