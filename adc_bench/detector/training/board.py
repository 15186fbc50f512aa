"""The course of a run for TensorBoard."""

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from torch.utils.tensorboard import SummaryWriter

FOLDER = "tensorboard"


class Board(Protocol):
    """Where figures by step go."""

    def show(self, step: int, values: Mapping[str, float]) -> None:
        """Write down figures, by name."""
        ...

    def close(self) -> None:
        """Bring all to disk."""
        ...


class TensorBoard:
    """Event files in a run's folder; those of a broken run count up to the step before `first`."""

    def __init__(self, run: Path, first: int) -> None:
        self._writer = SummaryWriter(run / FOLDER, purge_step=first)

    def show(self, step: int, values: Mapping[str, float]) -> None:
        """Write down figures, by name."""
        for name, value in values.items():
            self._writer.add_scalar(name, value, step)

    def close(self) -> None:
        """Bring all to disk."""
        self._writer.close()


class NoBoard:
    """For the processes that do not write."""

    def show(self, step: int, values: Mapping[str, float]) -> None:
        """Forget them."""

    def close(self) -> None:
        """Do nothing."""
