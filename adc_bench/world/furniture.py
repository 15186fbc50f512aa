"""What stands about the hall, off the road: cabinets, chairs, people-like figures, posters on the walls."""

from typing import Literal

import msgspec

FurnitureKind = Literal["cabinet", "chair", "person", "poster"]


class Furniture(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One piece: where its middle stands on the floor, the way it faces, and which of its kind's looks it has."""

    name: str
    kind: FurnitureKind
    x_m: float
    y_m: float
    yaw_rad: float
    variant: int = 0
