"""The network run by torch, as training needs it; its weights to and from files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from adc_bench.detector.model import Network, build_network, fused
from adc_bench.detector.note import refused
from adc_bench.detector.weights import read_weights, write_weights


class TorchBackend:
    """Runs a copy of a network, made for prediction alone, where the network is."""

    def __init__(self, network: Network) -> None:
        self._network = fused(network)
        self._device = next(network.parameters()).device

    @classmethod
    def load(cls, path: Path, threads: int) -> "TorchBackend":
        """Return the backend of a weights file; sets the number of torch's threads in this process.

        Raises:
            InputError: see `load_network`.
        """
        torch.set_num_threads(threads)
        return cls(load_network(path))

    @torch.inference_mode()
    def __call__(self, prepared: NDArray[np.float32], /) -> Sequence[NDArray[np.float32]]:
        """Return the answers of each branch, (n, c, p), for prepared pictures (n, 3, h, w)."""
        x = torch.from_numpy(prepared).to(self._device, memory_format=torch.channels_last)
        return [branch.cpu().numpy() for branch in self._network.branches(x)]


def save_network(path: Path, network: Network) -> None:
    """Write the weights of a network; equal weights give equal bytes."""
    state = {name: value.detach().cpu() for name, value in network.state_dict().items() if value.is_floating_point()}
    write_weights(path, {name: value.numpy() for name, value in state.items()}, network.config)


def load_network(path: Path) -> Network:
    """Return the network of a weights file, ready to predict.

    Raises:
        InputError: the file cannot be read (see `read_weights`), or its tensors do not fit its network.
    """
    tensors, note = read_weights(path)
    network = build_network(note.config, len(note.categories))
    try:
        network.load_state_dict({name: torch.from_numpy(tensor) for name, tensor in tensors.items()})
    except RuntimeError as error:
        first = str(error).splitlines()[-1].strip()
        raise refused(path, f"tensors that do not fit the network: {first}") from error
    return network.eval()
