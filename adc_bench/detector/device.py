"""Where torch computes."""

from typing import Literal

import torch

from adc_bench.errors import MachineError

Device = Literal["auto", "cpu", "cuda"]


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
