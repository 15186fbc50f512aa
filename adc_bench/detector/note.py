"""What stands in a weights file beside the tensors: what the network is, and what its classes are."""

from pathlib import Path

import msgspec

from adc_bench.errors import InputError
from adc_bench.world.categories import CATEGORIES

NOTE = "adc_bench"  # one metadata entry: several would be stored in no fixed order, and the bytes would differ
ARCHITECTURE = "adc/2"
WANTED = f"a weights file of architecture {ARCHITECTURE}"
TODO = "pass the weights of a `train-detector` run"


class ModelConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Sizes of the network: channels at stride 4 (half as many at 2), then at strides 8, 16 and 32, residual blocks
    there, channels of the neck and of the head, and the bins that a box' distance (in strides) is spread over.
    """

    stem: int = 32
    widths: tuple[int, int, int] = (48, 96, 128)
    depths: tuple[int, int, int] = (1, 2, 1)
    neck: int = 32
    head: int = 32
    bins: int = 16


class WeightsNote(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The note."""

    architecture: str
    config: ModelConfig
    categories: tuple[str, ...]


def read_note(path: Path, note_json: bytes) -> WeightsNote:
    """Return the note of a weights file.

    Raises:
        InputError: it cannot be read, or is of another architecture or other categories.
    """
    try:
        architecture = msgspec.json.decode(note_json, type=dict[str, object]).get("architecture")
        if architecture != ARCHITECTURE:
            raise refused(path, f"weights of architecture {architecture}")
        note = msgspec.json.decode(note_json, type=WeightsNote)
    except msgspec.DecodeError as error:
        raise refused(path, f"a note that cannot be read: {error}") from error
    if note.categories != CATEGORIES:
        raise refused(path, f"weights for other categories: {', '.join(note.categories)}")
    return note


def refused(path: Path, found: str) -> InputError:
    """Return the error of a weights file that cannot be used."""
    return InputError(where=str(path), found=found, wanted=WANTED, todo=TODO)
