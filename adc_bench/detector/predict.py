"""The detector as the driver uses it: a picture in, boxes with scores, categories and corners out."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.decode import Answers, DecodeConfig, decode
from adc_bench.detector.prepare import prepare
from adc_bench.world.frame import Detections

Array = NDArray[np.float32]
Runtime = Literal["onnx", "torch"]


class Backend(Protocol):
    """Runs a network."""

    def __call__(self, prepared: Array, /) -> Sequence[Array]:
        """Return the answers of each branch, (n, c, p), for prepared pictures (n, 3, h, w)."""
        ...


class Pictures(Protocol):
    """Pictures by number."""

    def __len__(self) -> int: ...

    def picture(self, index: int, /) -> NDArray[np.uint8]:
        """Return the picture (h, w, 3)."""
        ...


class Detector:
    """A trained network behind a call; on one number of threads equal pictures give equal answers, bit for bit."""

    def __init__(self, backend: Backend, config: DecodeConfig) -> None:
        self.backend, self.config = backend, config

    @classmethod
    def load(
        cls, path: Path, threads: int = 1, *, runtime: Runtime = "onnx", config: DecodeConfig | None = None
    ) -> "Detector":
        """Return the detector of a weights file, warmed up, run by ONNX Runtime or by torch.

        `threads` are those of the network; torch has one number of them in a process.

        Raises:
            InputError: the file cannot be read, or its tensors do not fit its network.
        """
        detector = cls(_backend(path, threads, runtime), config or DecodeConfig())
        detector(np.zeros((240, 320, 3), dtype=np.uint8))  # the first call builds what later ones reuse
        return detector

    def __call__(self, rgb: NDArray[np.uint8]) -> Detections:
        """Return what is on a picture (h, w, 3)."""
        return self.detect([rgb])[0]

    def detect(self, pictures: Sequence[NDArray[np.uint8]]) -> list[Detections]:
        """Return what is on each of several pictures of one size (h, w, 3)."""
        height, width, _ = pictures[0].shape
        answers = self.backend(prepare(pictures))
        return [decode(self.config, Answers(*one), (width, height)) for one in zip(*answers, strict=True)]


def _backend(path: Path, threads: int, runtime: Runtime) -> Backend:
    # Each runtime is imported where it is used: torch alone takes seconds.
    if runtime == "onnx":
        from adc_bench.detector.onnx_backend import OnnxBackend

        return OnnxBackend.load(path, threads)
    from adc_bench.detector.torch_backend import TorchBackend

    return TorchBackend.load(path, threads)


def predict_all(
    detector: Detector, source: Pictures, *, batch: int = 16, told: Callable[[int], None] = lambda done: None
) -> list[Detections]:
    """Return the detections on every picture of a dataset, `batch` at a time; `told` hears how many are done."""
    found: list[Detections] = []
    for first in range(0, len(source), batch):
        indices = range(first, min(first + batch, len(source)))
        found += detector.detect([source.picture(i) for i in indices])
        told(len(found))
    return found
