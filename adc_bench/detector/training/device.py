"""Where torch computes: on the CPU, on a GPU, or in several processes that `torchrun` started."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Literal, NamedTuple

import numpy as np
import torch
from torch import distributed

from adc_bench.errors import MachineError

Device = Literal["auto", "cpu", "cuda"]


class Place(NamedTuple):
    """A device, and which of how many processes this is."""

    device: torch.device
    rank: int = 0
    processes: int = 1

    @property
    def is_first(self) -> bool:
        """Whether this process is the one that writes and speaks."""
        return self.rank == 0

    def from_first(self, make: Callable[[], bytes]) -> bytes:
        """Return what `make` gives in the first process, in all; the others wait for it."""
        if self.processes == 1:
            return make()
        made = np.frombuffer(make() if self.is_first else b"", np.uint8)
        size = torch.tensor([made.size], device=self.device)
        distributed.broadcast(size, 0)
        content = torch.empty(int(size), dtype=torch.uint8)
        content[: made.size] = torch.from_numpy(made.copy())
        content = content.to(self.device)
        if content.numel():
            distributed.broadcast(content, 0)
        return content.cpu().numpy().tobytes()


CPU = Place(torch.device("cpu"))


@contextmanager
def take_place(device: Device) -> Iterator[Place]:
    """Yield the place of this process; under `torchrun` it is one of a group for as long.

    Raises:
        MachineError: cuda is asked for and there is none.
    """
    kind = choose_device(device)
    if not distributed.is_torchelastic_launched():
        yield Place(torch.device(kind))
        return
    chosen = torch.device(f"cuda:{os.environ['LOCAL_RANK']}" if kind == "cuda" else "cpu")
    if chosen.type == "cuda":
        torch.cuda.set_device(chosen)
    distributed.init_process_group("nccl" if chosen.type == "cuda" else "gloo")
    try:
        yield Place(chosen, distributed.get_rank(), distributed.get_world_size())
    finally:
        distributed.destroy_process_group()


def choose_device(device: Device) -> str:
    """Return cpu or cuda.

    Raises:
        MachineError: cuda is asked for and there is none.
    """
    if device == "cuda" and not torch.cuda.is_available():
        raise MachineError(
            where="--device cuda",
            found="no GPU that torch can use",
            wanted="a CUDA device",
            todo="leave --device out, or install a driver for the GPU",
        )
    if device == "auto":
        return "cuda" if torch.cuda.is_available() else "cpu"
    return device
