"""The network: a small convolutional pyramid that says, for each point of three grids, whether something is there,
what, how far its box reaches to the left, top, right and bottom, and about where its four corners are; and where
exactly the nearest corner of anything is, if one is near.
"""

from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from adc_bench.detector.decode import STRIDES
from adc_bench.detector.note import ModelConfig


class Prediction(NamedTuple):
    """Raw answers for n pictures at p points, lengths in strides.

    Whether there is an object, object_logits (n, p); which, class_logits (n, p, classes); how far its sides are,
    distance_logits (n, p, 4, bins); its four corners, keypoints (n, p, 4, 4): u and v from the point, logarithm of the
    error's scale, logit of being seen. Of any object's corner nearby, corners (n, p, 4): logit that there is one, u and
    v to it, logarithm of the error's scale.
    """

    object_logits: Tensor
    class_logits: Tensor
    distance_logits: Tensor
    keypoints: Tensor
    corners: Tensor

    def scores(self) -> Tensor:
        """Return (n, p, classes): how likely an object of each class is seen from each point."""
        return self.object_logits.sigmoid()[..., None] * self.class_logits.softmax(dim=-1)


class ConvUnit(nn.Sequential):
    """Convolution, batch normalisation, rectifier."""

    def __init__(self, inside: int, outside: int, kernel: int = 3, stride: int = 1) -> None:
        super().__init__(
            nn.Conv2d(inside, outside, kernel, stride, (kernel - 1) // 2, bias=False),
            nn.BatchNorm2d(outside, eps=1e-3),
            nn.ReLU(inplace=True),
        )


class Residual(nn.Module):
    """Two 3x3 units with half the channels between them, added to their input."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.units = nn.Sequential(ConvUnit(channels, channels // 2), ConvUnit(channels // 2, channels))

    def forward(self, x: Tensor) -> Tensor:
        """Return (n, c, h, w) for (n, c, h, w)."""
        out: Tensor = x + self.units(x)
        return out


class Backbone(nn.Module):
    """Pictures to features at strides 8, 16 and 32."""

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.stem = nn.Sequential(
            ConvUnit(3, config.stem // 2, stride=2), ConvUnit(config.stem // 2, config.stem, stride=2)
        )
        inside, stages = config.stem, []
        for width, depth in zip(config.widths, config.depths, strict=True):
            stages.append(nn.Sequential(ConvUnit(inside, width, stride=2), *(Residual(width) for _ in range(depth))))
            inside = width
        self.stages = nn.ModuleList(stages)

    def forward(self, x: Tensor) -> list[Tensor]:
        """Return three maps for pictures (n, 3, h, w)."""
        x, features = self.stem(x), []
        for stage in self.stages:
            x = stage(x)
            features.append(x)
        return features


class Neck(nn.Module):
    """Mixes the three maps: coarse knowledge down to the fine map, then fine knowledge up again."""

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        c = config.neck
        self.lateral = nn.ModuleList(ConvUnit(width, c, kernel=1) for width in config.widths)
        self.smooth = nn.ModuleList((Residual(c), Residual(c)))
        self.down = nn.ModuleList((ConvUnit(c, c, stride=2), ConvUnit(c, c, stride=2)))

    def forward(self, features: list[Tensor]) -> list[Tensor]:
        """Return three maps of equal channels."""
        fine, middle, coarse = (unit(x) for unit, x in zip(self.lateral, features, strict=True))
        middle = self.smooth[1](middle + nn.functional.interpolate(coarse, scale_factor=2.0))
        fine = self.smooth[0](fine + nn.functional.interpolate(middle, scale_factor=2.0))
        middle = middle + self.down[0](fine)
        return [fine, middle, coarse + self.down[1](middle)]


class Head(nn.Module):
    """Decoupled answers of one map: what it is from one branch, whether and where it is from another, its corners from
    a third.
    """

    def __init__(self, config: ModelConfig, classes: int) -> None:
        super().__init__()
        self.what = nn.Sequential(ConvUnit(config.neck, config.head), nn.Conv2d(config.head, classes, 1))
        last = nn.Conv2d(config.head, 1 + 4 * config.bins, 1)
        _expect_nothing(last, 1)
        self.where = nn.Sequential(ConvUnit(config.neck, config.head), last)
        last = nn.Conv2d(config.head, 4 + 16, 1)
        _expect_nothing(last, 1)
        self.corners = nn.Sequential(ConvUnit(config.neck, config.head), last)

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return the three branches' answers, (n, c, h w) each, as `decode.Answers` has them."""
        return self.what(x).flatten(2), self.where(x).flatten(2), self.corners(x).flatten(2)


class Network(nn.Module):
    """Backbone, neck and one head per stride."""

    def __init__(self, config: ModelConfig, classes: int) -> None:
        super().__init__()
        self.config, self.classes = config, classes
        self.backbone = Backbone(config)
        self.neck = Neck(config)
        self.heads = nn.ModuleList(Head(config, classes) for _ in STRIDES)

    def forward(self, pictures: Tensor) -> Prediction:
        """Return the answers for prepared pictures (n, 3, h, w), h and w multiples of 32; points ordered by stride,
        then row, then column, as `grid_points` lists them.
        """
        what, where, corners = (branch.mT.contiguous() for branch in self.branches(pictures))
        return Prediction(
            where[..., 0],
            what,
            where[..., 1:].reshape(len(where), -1, 4, self.config.bins),
            corners[..., 4:].reshape(len(corners), -1, 4, 4),
            corners[..., :4],
        )

    def branches(self, pictures: Tensor) -> list[Tensor]:
        """Return the same answers as they leave the heads, (n, c, p) each."""
        maps = self.neck(self.backbone(pictures))
        answers = [head(x) for head, x in zip(self.heads, maps, strict=True)]
        return [torch.cat(parts, dim=2) for parts in zip(*answers, strict=True)]


def _expect_nothing(convolution: nn.Conv2d, channels: int) -> None:
    """Set the biases so that at first the first `channels` say "nothing" with 99 %."""
    assert convolution.bias is not None
    nn.init.constant_(convolution.bias[:channels], -4.6)


def build_network(config: ModelConfig, classes: int, seed: int = 0) -> Network:
    """Return a network with weights drawn from `seed`; the caller's random state is left as it was."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network = Network(config, classes)
        for module in network.modules():
            if isinstance(module, nn.Conv2d) and module.bias is None:
                nn.init.kaiming_normal_(module.weight, mode="fan_out", nonlinearity="relu")
    # Kernels that lie channels-last in memory are the CPU's fastest.
    for parameter in network.parameters():
        if parameter.ndim == 4:
            parameter.data = parameter.data.contiguous(memory_format=torch.channels_last)
    return network


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
