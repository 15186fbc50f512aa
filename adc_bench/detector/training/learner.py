"""What learns: a network, the running mean of its weights, and its optimiser; one step at a time."""

import math

import torch
from torch import nn
from torch.nn.parallel import DistributedDataParallel
from torch.optim import AdamW

from adc_bench.detector.model import Network, build_network
from adc_bench.detector.training.batches import Batch
from adc_bench.detector.training.boxes import grid_points
from adc_bench.detector.training.device import Place
from adc_bench.detector.training.loss import Parts, detection_loss
from adc_bench.detector.training.recipe import Recipe, TrainConfig
from adc_bench.detector.training.targets import Truth
from adc_bench.world.categories import CATEGORIES

LOSSES = ("loss", *Parts._fields)
NO_LOSSES = (0.0,) * len(LOSSES)


class Learner:
    """A network in training, for `steps` steps in all. In several processes each sees its share of a batch, and they
    take the mean of their gradients, so that all hold the same weights.
    """

    def __init__(self, recipe: Recipe, place: Place, steps: int) -> None:
        self.recipe, self.device, self.steps = recipe, place.device, steps
        seed = recipe.train.seed
        self.network = build_network(recipe.model, len(CATEGORIES), seed).to(place.device)
        self.average = build_network(recipe.model, len(CATEGORIES), seed).to(place.device).requires_grad_(False)
        self.optimizer = AdamW(weight_groups(self.network, recipe.train.weight_decay), fused=True)
        self._shared: nn.Module = self.network if place.processes == 1 else DistributedDataParallel(self.network)

    def look(self, batch: Batch) -> tuple[list[float], bool]:
        """Work out a batch' gradients, clipped; return the `LOSSES` and whether all is finite."""
        self.network.train()
        pictures = batch.pictures.to(self.device, memory_format=torch.channels_last)
        truths = [Truth(*(part.to(self.device) for part in truth)) for truth in batch.truths]
        points, strides = grid_points(pictures.shape[2], pictures.shape[3], self.device)
        with torch.autocast(self.device.type, torch.bfloat16, enabled=self.device.type == "cuda"):
            prediction = self._shared(pictures)
        loss, parts = detection_loss(self.recipe.loss, prediction, truths, points, strides)
        self.optimizer.zero_grad()
        torch.autograd.backward(loss)
        norm = nn.utils.clip_grad_norm_(self.network.parameters(), self.recipe.train.gradient_norm_max)
        return torch.stack([loss, *parts]).tolist(), bool(torch.isfinite(loss) & torch.isfinite(norm))

    def learn(self, step: int) -> None:
        """Change the weights by the gradients at hand; steps count from 0."""
        config = self.recipe.train
        for group in self.optimizer.param_groups:
            group["lr"] = learning_rate(config, step, self.steps)
        self.optimizer.step()
        # While the weights move fast, their mean follows fast.
        update_average(self.average, self.network, decay=min(config.average_decay, (1 + step) / (10 + step)))


def learning_rate(config: TrainConfig, step: int, steps: int) -> float:
    """Return the rate at a step: a straight rise, then a cosine down to a hundredth."""
    rise = min(1.0, (step + 1) / config.warmup_steps)
    fall = 0.01 + 0.99 * (1 + math.cos(math.pi * step / steps)) / 2
    return config.learning_rate * rise * fall


def weight_groups(network: Network, weight_decay: float) -> list[dict[str, object]]:
    """Return the parameters in two groups: kernels, which decay, and biases and normalisation, which do not."""
    kernels = [parameter for parameter in network.parameters() if parameter.ndim > 1]
    others = [parameter for parameter in network.parameters() if parameter.ndim <= 1]
    return [{"params": kernels, "weight_decay": weight_decay}, {"params": others, "weight_decay": 0.0}]


@torch.no_grad()
def update_average(average: Network, network: Network, *, decay: float) -> None:
    """Move the running mean of the weights, and of the normalisation's statistics, towards the network's."""
    for mean, value in zip(average.state_dict().values(), network.state_dict().values(), strict=True):
        if mean.is_floating_point():
            mean.lerp_(value, 1 - decay)
        else:
            mean.copy_(value)
