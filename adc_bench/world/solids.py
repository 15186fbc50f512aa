"""Solid things: shapes that stand for good, and bodies made of them that can be pushed."""

from typing import Literal

import msgspec
import numpy as np

from adc_bench.geometry import Pose2, Pose3, rotation_zyx
from adc_bench.world.categories import Category

Kind = Literal["gantry", "panel", "wall", "tunnel", "sign", "cabinet", "person", "poster", "box", "cone", "chair"]
Shape = Literal["box", "cylinder", "cone"]


class Solid(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A solid: its centre, size along its own axes, and attitude (yaw, then pitch: nose down positive).

    A cylinder's or cone's axis is its own z; its size is that of the box around it, a cone's tip is at the top.
    """

    name: str
    kind: Kind
    centre_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    yaw_rad: float = 0.0
    pitch_rad: float = 0.0
    albedo: tuple[float, float, float] = (0.8, 0.8, 0.8)
    shape: Shape = "box"

    def pose_world_solid(self) -> Pose3:
        """Return where the solid's centre and axes are in the world (of a body's part: in the body)."""
        return Pose3(rotation=rotation_zyx(self.yaw_rad, self.pitch_rad, 0.0), translation_m=np.array(self.centre_m))


class Body(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A thing that moves when it is hit: where it stands at first, its mass and friction, and its parts.

    The body's origin is on the floor under its middle, z up; the parts' centres and attitudes are in the body's frame.
    """

    name: str
    kind: Kind
    pose: Pose2
    mass_kg: float
    friction: float
    parts: tuple[Solid, ...]
    category: Category | None = None  # what it is labelled as
