"""The three qualities of a picture: our own shader pack, and two of SAPIEN's that light the same meshes themselves.

Scored drives always use `fast`; the others are for looking and for data. Labels always come from our own pack.
"""

from collections.abc import Mapping
from importlib import resources
from typing import Literal, get_args

import msgspec

Quality = Literal["fast", "standard", "raytraced"]
QUALITIES: tuple[Quality, ...] = get_args(Quality)


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
