"""SAPIEN's shader packs that draw the arena beside our own (`fast`); they light the same meshes themselves.

Labels always come from our own pack's label picture.
"""

from collections.abc import Mapping
from importlib import resources

import msgspec

from adc_bench.world.quality import Quality


class Pack(msgspec.Struct, frozen=True, kw_only=True):
    """How one of SAPIEN's shader packs is used.

    Attributes:
        folder: the pack's name in the sapien package.
        picture: the pack's picture of linear radiance, alpha how much of a pixel is not background.
        bakes_diffuse: whether the light of sky and lamps is put into the surfaces, where the pack cannot shade it.
        samples: paths a pixel, 0 where the pack rasterises.
        depth: bounces after the first hit.
    """

    folder: str
    picture: str
    bakes_diffuse: bool
    samples: int = 0
    depth: int = 0

    @property
    def is_traced(self) -> bool:
        """Whether the pack traces paths."""
        return self.samples > 0

    @property
    def path(self) -> str:
        """The pack's folder on this machine."""
        return str(resources.files("sapien") / "vulkan_shader" / self.folder)


PACKS: Mapping[Quality, Pack] = {
    "standard": Pack(folder="default", picture="Lighting", bakes_diffuse=True),
    "raytraced": Pack(folder="rt", picture="HdrColor", bakes_diffuse=False, samples=16, depth=2),
}
