"""The network: a small convolutional pyramid that says, for each point of three grids, whether something is there,
what, and how far its box reaches to the left, top, right and bottom.
"""

from typing import NamedTuple

import msgspec
import torch
from torch import Tensor, nn

ARCHITECTURE = "adc-n/1"
STRIDES = (8, 16, 32)
DEVIATION_FLOOR = 4.0  # grey levels; a picture of nothing but noise is not blown up to full contrast


class ModelConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Sizes of the network: channels at stride 4 (half as many at 2), then at strides 8, 16 and 32, residual blocks
    there, channels of the neck and of the head, and the bins that a box' distance (in strides) is spread over.
    """

    stem: int = 32
    widths: tuple[int, int, int] = (48, 96, 128)
    depths: tuple[int, int, int] = (1, 2, 1)
    neck: int = 32
    head: int = 32
    bins: int = 16


class Prediction(NamedTuple):
    """Raw answers at p points: whether there is an object, object_logits (n, p); which, class_logits (n, p, classes);
    how far its sides are, distance_logits (n, p, 4, bins).
    """

    object_logits: Tensor
    class_logits: Tensor
    distance_logits: Tensor

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
    """Decoupled answers of one map: what it is from one branch, whether and where it is from another."""

    def __init__(self, config: ModelConfig, classes: int) -> None:
        super().__init__()
        self.what = nn.Sequential(ConvUnit(config.neck, config.head), nn.Conv2d(config.head, classes, 1))
        last = nn.Conv2d(config.head, 1 + 4 * config.bins, 1)
        assert last.bias is not None
        nn.init.constant_(last.bias[:1], -4.6)  # at first everything is background with 99 %
        self.where = nn.Sequential(ConvUnit(config.neck, config.head), last)

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """Return class logits (n, h w, classes), and object and distance logits (n, h w, 1 + 4 bins)."""
        return self.what(x).flatten(2).mT, self.where(x).flatten(2).mT


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
        maps = self.neck(self.backbone(pictures))
        answers = [head(x) for head, x in zip(self.heads, maps, strict=True)]
        what, where = (torch.cat(parts, dim=1) for parts in zip(*answers, strict=True))
        return Prediction(where[..., 0], what, where[..., 1:].reshape(*where.shape[:2], 4, self.config.bins))


def prepare(pictures: Tensor) -> Tensor:
    """Return pictures (n, h, w, 3) uint8 as network input (n, 3, h', w') float32: each with mean 0 and deviation about
    1, so that the light's level matters little, padded with zeros at the bottom and the right to multiples of 32.
    """
    count, height, width, colours = pictures.shape
    x = pictures.float()
    x -= x.mean(dim=(1, 2, 3), keepdim=True)
    deviation = x.square().mean(dim=(1, 2, 3), keepdim=True).sqrt()
    padded_height, padded_width = (side + -side % STRIDES[-1] for side in (height, width))
    padded = x.new_zeros(count, padded_height, padded_width, colours)
    padded[:, :height, :width] = x.div_(deviation + DEVIATION_FLOOR)
    return padded.permute(0, 3, 1, 2)  # a view, which already has the channels-last layout


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
