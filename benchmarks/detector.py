"""What the detector costs: one picture through decode and suppression, and a training step, at 320x240.

Usage: python benchmarks/detector.py [--weights FILE] [--repeats 100]

The pictures are noise: nothing in the network's cost depends on what they show, and a training step gets two boxes a
picture. Medians over the repeats.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch

from adc_bench.detector.boxes import grid_points
from adc_bench.detector.loss import detection_loss
from adc_bench.detector.model import Network, build_network, prepare
from adc_bench.detector.predict import Detector
from adc_bench.detector.recipe import RECIPES, Recipe, load_recipe
from adc_bench.detector.targets import Truth
from adc_bench.detector.weights import load_weights
from adc_bench.world.categories import CATEGORIES


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--weights", type=Path, help="weights to time; untrained ones if left out")
    parser.add_argument("--repeats", type=int, default=100)
    options = parser.parse_args()
    recipe = load_recipe(RECIPES / "demo.toml")
    network = load_weights(options.weights) if options.weights else build_network(recipe.model, len(CATEGORIES))
    print(f"parameters: {sum(parameter.numel() for parameter in network.parameters()):,}")
    print("| threads | ms a picture | training pictures/s |\n|---|---|---|")
    for threads in (1, 2):
        torch.set_num_threads(threads)
        inference_s = inference_time_s(network, options.repeats)
        step_s = training_time_s(recipe, max(options.repeats // 10, 3))
        print(f"| {threads} | {1000 * inference_s:.1f} | {recipe.train.batch / step_s:.0f} |")


def inference_time_s(network: Network, repeats: int) -> float:
    detector, rgb = Detector(network), pictures(1)[0]
    return median_time_s(lambda: detector(rgb), repeats)


def training_time_s(recipe: Recipe, repeats: int) -> float:
    network = build_network(recipe.model, len(CATEGORIES)).train()
    optimizer = torch.optim.AdamW(network.parameters())
    rgb = torch.from_numpy(pictures(recipe.train.batch))
    boxes = torch.tensor([[40.0, 120.0, 200.0, 170.0], [200.0, 50.0, 240.0, 73.0]])
    truth = Truth(boxes, torch.tensor([0, 1]), torch.tensor([False, False]))

    def step() -> None:
        x = prepare(rgb)
        points, strides = grid_points(x.shape[2], x.shape[3])
        loss, _ = detection_loss(recipe.loss, network(x), [truth] * len(rgb), points, strides)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()

    return median_time_s(step, repeats)


def pictures(count: int) -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (count, 240, 320, 3), dtype=np.uint8)


def median_time_s(work: Callable[[], object], repeats: int) -> float:
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


if __name__ == "__main__":
    main()
