"""The network of a weights file as an ONNX graph, put together without torch; `model.Network` node by node."""

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from adc_bench.detector.decode import Answers
from adc_bench.detector.note import NOTE, WeightsNote

OPSET, IR_VERSION = 17, 8
EPSILON = 1e-3  # of the normalisation
Tensors = Mapping[str, NDArray[np.float32]]


def onnx_model(tensors: Tensors, note: WeightsNote) -> bytes:
    """Return the ONNX file of a network: prepared `pictures` (n, 3, h, w), h and w multiples of 32, to the answers
    of each branch, normalisations folded into their convolutions. Equal weights give equal bytes.

    Raises:
        KeyError: a tensor is missing.
    """
    graph = _Graph(tensors, note)
    graph.heads(graph.neck(*graph.backbone("pictures")))
    shapes = {name: ["n", f"{name}_channels", "p"] for name in Answers._fields}
    model = helper.make_model(
        helper.make_graph(
            graph.nodes,
            "detector",
            [helper.make_tensor_value_info("pictures", TensorProto.FLOAT, ["n", 3, "h", "w"])],
            [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in shapes.items()],
            graph.constants,
        ),
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR_VERSION,
        producer_name="adc-bench",
    )
    helper.set_model_props(model, {NOTE: msgspec.json.encode(note).decode()})
    onnx.checker.check_model(model)
    return bytes(model.SerializeToString(deterministic=True))


class _Graph:
    """Nodes and constants so far; each method adds some and returns the name of what comes out."""

    def __init__(self, tensors: Tensors, note: WeightsNote) -> None:
        self.tensors, self.note = tensors, note
        self.nodes: list[onnx.NodeProto] = []
        self.constants: list[onnx.TensorProto] = []

    def backbone(self, x: str) -> list[str]:
        x = self.unit(self.unit(x, "backbone.stem.0", stride=2), "backbone.stem.1", stride=2)
        features = []
        for stage, depth in enumerate(self.note.config.depths):
            x = self.unit(x, f"backbone.stages.{stage}.0", stride=2)
            for k in range(1, depth + 1):
                x = self.residual(x, f"backbone.stages.{stage}.{k}")
            features.append(x)
        return features

    def neck(self, *features: str) -> list[str]:
        fine, middle, coarse = (self.unit(x, f"neck.lateral.{k}") for k, x in enumerate(features))
        middle = self.residual(self.add(middle, self.twice(coarse)), "neck.smooth.1")
        fine = self.residual(self.add(fine, self.twice(middle)), "neck.smooth.0")
        middle = self.add(middle, self.unit(fine, "neck.down.0", stride=2))
        return [fine, middle, self.add(coarse, self.unit(middle, "neck.down.1", stride=2))]

    def heads(self, maps: list[str]) -> None:
        for branch in Answers._fields:
            parts = [self.branch(x, f"heads.{k}.{branch}") for k, x in enumerate(maps)]
            self.node("Concat", parts, branch, axis=2)

    def branch(self, x: str, name: str) -> str:
        """A unit and a 1x1 convolution; (n, c, h w) comes out."""
        weight, bias = self.tensors[f"{name}.1.weight"], self.tensors[f"{name}.1.bias"]
        x = self.unit(x, f"{name}.0")
        x = self.node("Conv", [x, self.constant(weight), self.constant(bias)], kernel_shape=[1, 1])
        return self.node("Reshape", [x, self.constant(np.array([0, len(bias), -1], np.int64))])

    def unit(self, x: str, name: str, stride: int = 1) -> str:
        weight, bias = self.folded(name)
        side = weight.shape[-1]
        x = self.node(
            "Conv",
            [x, self.constant(weight), self.constant(bias)],
            kernel_shape=[side, side],
            strides=[stride, stride],
            pads=4 * [(side - 1) // 2],
        )
        return self.node("Relu", [x])

    def folded(self, name: str) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """The kernel and the bias of a unit, its normalisation folded in."""
        scale, shift, mean, variance = (
            self.tensors[f"{name}.1.{part}"].astype(np.float64)
            for part in ("weight", "bias", "running_mean", "running_var")
        )
        factor = scale / np.sqrt(variance + EPSILON)
        kernel = self.tensors[f"{name}.0.weight"] * factor[:, None, None, None]
        return kernel.astype(np.float32), (shift - mean * factor).astype(np.float32)

    def residual(self, x: str, name: str) -> str:
        return self.add(x, self.unit(self.unit(x, f"{name}.units.0"), f"{name}.units.1"))

    def add(self, x: str, y: str) -> str:
        return self.node("Add", [x, y])

    def twice(self, x: str) -> str:
        scales = self.constant(np.array([1, 1, 2, 2], np.float32))
        return self.node(
            "Resize", [x, "", scales], mode="nearest", coordinate_transformation_mode="asymmetric", nearest_mode="floor"
        )

    def constant(self, value: NDArray[np.float32] | NDArray[np.int64]) -> str:
        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(value), name))
        return name

    def node(self, kind: str, inputs: list[str], out: str = "", **attributes: Any) -> str:
        name = out or f"x{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [name], **attributes))
        return name
