"""One detector, two runtimes."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from conftest import SMALL
from numpy.typing import NDArray
from torch import nn

from adc_bench.detector import Detector
from adc_bench.detector.decode import Answers, DecodeConfig
from adc_bench.detector.model import build_network
from adc_bench.detector.note import ModelConfig
from adc_bench.detector.onnx_backend import OnnxBackend
from adc_bench.detector.onnx_graph import onnx_model
from adc_bench.detector.torch_backend import TorchBackend, save_network
from adc_bench.detector.weights import read_weights
from adc_bench.world.categories import CATEGORIES

EVERYTHING = DecodeConfig(score_min=0.0, count_max=20)


@pytest.fixture(scope="module", params=[SMALL, ModelConfig(), ModelConfig(depths=(2, 3, 2), neck=48, bins=12)])
def weights(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A network whose normalisations all do something."""
    network = build_network(request.param, len(CATEGORIES), seed=1)
    generator = torch.Generator().manual_seed(0)
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            assert module.running_mean is not None and module.running_var is not None
            module.running_mean.normal_(0, 0.1, generator=generator)
            module.running_var.uniform_(0.5, 2, generator=generator)
            module.weight.data.uniform_(0.5, 1.2, generator=generator)
            module.bias.data.normal_(0, 0.1, generator=generator)
    path = tmp_path_factory.mktemp("weights") / "w.safetensors"
    save_network(path, network)
    return path


@pytest.mark.parametrize("shape", [(1, 3, 256, 320), (3, 3, 128, 160), (2, 3, 32, 32)])
def test_onnx_answers_as_torch_does(weights: Path, shape: tuple[int, ...]) -> None:
    x = np.random.default_rng(0).normal(size=shape).astype(np.float32)
    ours, theirs = OnnxBackend.load(weights, 1)(x), TorchBackend.load(weights, 1)(x)
    assert len(ours) == len(theirs) == len(Answers._fields)
    for name, one, other in zip(Answers._fields, ours, theirs, strict=True):
        assert one.shape == other.shape and one.dtype == other.dtype == np.float32
        assert np.abs(one - other).max() < 1e-4, name


def test_the_graph_is_whole_and_repeats_itself(weights: Path) -> None:
    model = onnx_model(*read_weights(weights))
    assert model == onnx_model(*read_weights(weights))
    graph = onnx.load_from_string(model)
    onnx.checker.check_model(graph, full_check=True)
    assert tuple(output.name for output in graph.graph.output) == Answers._fields
    assert {node.op_type for node in graph.graph.node} <= {
        "Add", "Concat", "Conv", "Relu", "Reshape", "Resize"
    }  # fmt: skip


def picture(rng: np.random.Generator) -> NDArray[np.uint8]:
    return rng.integers(0, 256, (120, 160, 3), dtype=np.uint8)


@pytest.mark.parametrize("runtime", ["onnx", "torch"])
def test_a_detector_repeats_itself_whatever_stands_beside_a_picture(weights: Path, runtime: str) -> None:
    detector = Detector.load(weights, runtime=runtime, config=EVERYTHING)  # type: ignore[arg-type]
    rng = np.random.default_rng(3)
    pictures = [picture(rng) for _ in range(3)]
    alone, again = detector(pictures[1]), detector(pictures[1])
    assert np.array_equal(alone.boxes_px, again.boxes_px) and np.array_equal(alone.scores, again.scores)
    assert np.array_equal(alone.keypoints_px, again.keypoints_px)
    beside = detector.detect(pictures)[1]
    assert np.allclose(alone.scores, beside.scores, atol=1e-5)
    assert alone.boxes_px.dtype == np.float32 and alone.category_ids.dtype == np.int64
    assert alone.category_ids.min() >= 1 and (np.diff(alone.scores) <= 0).all()


def test_the_driver_needs_no_torch(weights: Path) -> None:

    code = (
        "import sys; from pathlib import Path; import numpy as np; from adc_bench.detector import Detector; "
        f"Detector.load(Path({str(weights)!r}))(np.zeros((120, 160, 3), np.uint8)); "
        "assert 'torch' not in sys.modules, 'torch was imported'"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
