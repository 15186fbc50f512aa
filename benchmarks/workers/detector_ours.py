"""The detector's turns. usage: detector_ours.py call WEIGHTS RUNTIME THREADS | train THREADS BATCH"""

import sys
from pathlib import Path

import numpy as np
from turns import serve


def call(weights: str, runtime: str, threads: int) -> None:
    from adc_bench.detector import Detector

    detector = Detector.load(Path(weights), threads, runtime=runtime)
    rgb = np.random.default_rng(0).integers(0, 256, (240, 320, 3), dtype=np.uint8)
    serve(lambda: detector(rgb))


def train(threads: int, batch: int) -> None:
    import torch

    from adc_bench.detector.model import build_network
    from adc_bench.detector.note import ModelConfig
    from adc_bench.detector.training.boxes import grid_points
    from adc_bench.detector.training.loss import LossConfig, detection_loss
    from adc_bench.detector.training.targets import Truth
    from adc_bench.world.categories import CATEGORIES

    torch.set_num_threads(threads)
    network = build_network(ModelConfig(), len(CATEGORIES)).train()
    optimizer = torch.optim.AdamW(network.parameters())
    x = torch.randn(batch, 3, 256, 320).contiguous(memory_format=torch.channels_last)
    points, strides = grid_points(256, 320)
    boxes = torch.tensor([[40.0, 120.0, 200.0, 170.0], [200.0, 50.0, 240.0, 73.0]])
    truth = Truth(boxes, torch.tensor([0, 1]), torch.tensor([False, False]), torch.ones(2, 4, 3))

    def step() -> None:
        loss, _ = detection_loss(LossConfig(), network(x), [truth] * batch, points, strides)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()

    step()
    serve(step)


if __name__ == "__main__":
    if sys.argv[1] == "call":
        call(sys.argv[2], sys.argv[3], int(sys.argv[4]))
    else:
        train(int(sys.argv[2]), int(sys.argv[3]))
