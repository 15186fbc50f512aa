"""What is set up for a trial beside the course's fixed furniture: tunnel, boxes, road-works."""

import msgspec

from adc_bench.world.arena import Tunnel

Place = tuple[float, float]  # x, y in the world, metres


class BoxPlace(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a green box stands."""

    x_m: float
    y_m: float
    yaw_rad: float = 0.0


class Works(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Road-works: two rows of cones, each joined by tape from cone to cone, in driving order.

    The corridor to be driven lies between the rows; `left` and `right` are seen by the driver.
    """

    left: tuple[Place, ...]
    right: tuple[Place, ...]


class Layout(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One set-up, complete. `signs`: the twelve vertical signs stand round the loops."""

    name: str = "open"
    tunnel: Tunnel | None = None
    boxes: tuple[BoxPlace, ...] = ()
    works: Works | None = None
    signs: bool = False
