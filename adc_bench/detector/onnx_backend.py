"""The network run by ONNX Runtime, as driving needs it: no torch."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import onnxruntime as ort
from numpy.typing import NDArray
from onnx.checker import ValidationError
from onnxruntime.capi import onnxruntime_pybind11_state as ort_errors

from adc_bench.detector.note import refused
from adc_bench.detector.onnx_graph import onnx_model
from adc_bench.detector.weights import read_weights

_UNFIT = (KeyError, ValidationError, ort_errors.Fail, ort_errors.InvalidArgument, ort_errors.InvalidGraph)


class OnnxBackend:
    """Runs an ONNX graph on the CPU."""

    def __init__(self, model: bytes, threads: int) -> None:
        options = ort.SessionOptions()
        options.intra_op_num_threads, options.inter_op_num_threads = threads, 1
        options.log_severity_level = 4  # what it would log it raises as well
        self._session = ort.InferenceSession(model, options, providers=["CPUExecutionProvider"])

    @classmethod
    def load(cls, path: Path, threads: int) -> "OnnxBackend":
        """Return the backend of a weights file.

        Raises:
            InputError: the file cannot be read (see `read_weights`), or its tensors do not fit its network.
        """
        tensors, note = read_weights(path)
        try:
            return cls(onnx_model(tensors, note), threads)
        except _UNFIT as error:
            first = str(error).splitlines()[0]
            raise refused(path, f"tensors that do not fit the network: {first}") from error

    def __call__(self, prepared: NDArray[np.float32], /) -> Sequence[NDArray[np.float32]]:
        """Return the answers of each branch, (n, c, p), for prepared pictures (n, 3, h, w)."""
        answers: list[NDArray[np.float32]] = self._session.run(None, {"pictures": prepared})
        return answers
