"""The detector as the driver uses it: a picture in, boxes with scores and categories out."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from adc_bench.detector.boxes import grid_points, select
from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.model import ConvUnit, Network, build_network, prepare
from adc_bench.detector.weights import load_weights
from adc_bench.world.frame import Detections


class Detector:
    """A trained network behind a call; on one number of threads equal pictures give equal answers, bit for bit."""

    def __init__(
        self, network: Network, *, score_min: float = 0.25, overlap_max: float = 0.6, count_max: int = 100
    ) -> None:
        self.network = fused(network)
        self.device = next(network.parameters()).device
        self.score_min, self.overlap_max, self.count_max = score_min, overlap_max, count_max

    @classmethod
    def load(cls, path: Path, threads: int = 1, *, score_min: float = 0.25) -> "Detector":
        """Return the detector of a weights file, warmed up; sets the number of torch's threads in this process.

        Raises:
            InputError: see `load_weights`.
        """
        torch.set_num_threads(threads)
        detector = cls(load_weights(path), score_min=score_min)
        detector(np.zeros((240, 320, 3), dtype=np.uint8))  # the first call builds what later ones reuse
        return detector

    def __call__(self, rgb: NDArray[np.uint8]) -> Detections:
        """Return what is on a picture (h, w, 3)."""
        return self.detect([rgb])[0]

    @torch.inference_mode()
    def detect(self, pictures: Sequence[NDArray[np.uint8]]) -> list[Detections]:
        """Return what is on each of several pictures of one size (h, w, 3)."""
        height, width, _ = pictures[0].shape
        x = prepare(torch.from_numpy(np.stack(pictures)).to(self.device))
        prediction = self.network(x)
        points, strides = grid_points(x.shape[2], x.shape[3], self.device)
        found = []
        for k in range(len(pictures)):
            boxes, scores, classes = select(
                prediction,
                k,
                points,
                strides,
                size_px=(width, height),
                score_min=self.score_min,
                overlap_max=self.overlap_max,
                count_max=self.count_max,
            )
            found.append(
                Detections(
                    boxes_px=boxes.cpu().numpy(),
                    scores=scores.cpu().numpy(),
                    category_ids=classes.cpu().numpy() + 1,
                )
            )
        return found


def fused(network: Network) -> Network:
    """Return a copy for prediction alone, with each normalisation folded into its convolution."""
    copy = build_network(network.config, network.classes).to(next(network.parameters()).device)
    copy.load_state_dict(network.state_dict())
    copy.eval()
    for unit in [module for module in copy.modules() if isinstance(module, ConvUnit)]:
        convolution, normalisation = unit[0], unit[1]
        assert isinstance(convolution, nn.Conv2d) and isinstance(normalisation, nn.BatchNorm2d)
        unit[0] = fuse_conv_bn_eval(convolution, normalisation)
        del unit[1]
    return copy.requires_grad_(False)


def predict_all(
    detector: Detector, source: LabelledPictures, *, batch: int = 16, told: Callable[[int], None] = lambda done: None
) -> list[Detections]:
    """Return the detections on every picture of a dataset, `batch` at a time; `told` hears how many are done."""
    found: list[Detections] = []
    for first in range(0, len(source), batch):
        indices = range(first, min(first + batch, len(source)))
        found += detector.detect([source.picture(i) for i in indices])
        told(len(found))
    return found
