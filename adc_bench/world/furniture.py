"""What stands about the hall, off the road: cabinets, chairs, people-like figures, posters on the walls.

No source gives figures for these; sizes are those of common things.
"""

from typing import Literal

import msgspec

from adc_bench.geometry import Pose2
from adc_bench.world.solids import Body, Kind, Shape, Solid

FurnitureKind = Literal["cabinet", "chair", "person", "poster"]
Size = tuple[float, float, float]
Albedo = tuple[float, float, float]

CHAIR_MASS_KG, CHAIR_FRICTION = 4.0, 0.4
POSTER_THICKNESS_M = 0.02
NECK_M = 0.07
# (length x: front to back, width y, height) and albedo of each variant.
CABINETS: tuple[tuple[Size, Albedo], ...] = (
    ((0.45, 0.80, 1.80), (0.55, 0.56, 0.58)),
    ((0.50, 1.20, 1.00), (0.45, 0.33, 0.20)),
    ((0.60, 0.60, 0.75), (0.70, 0.68, 0.60)),
    ((0.40, 1.00, 2.00), (0.20, 0.28, 0.36)),
    ((0.80, 1.60, 0.74), (0.62, 0.58, 0.50)),
)
CHAIRS: tuple[Albedo, ...] = ((0.10, 0.10, 0.11), (0.55, 0.12, 0.10), (0.12, 0.22, 0.50), (0.60, 0.45, 0.28))
# Height, albedo of legs and of torso; odd variants wear a skirt-like cone in place of legs.
PEOPLE: tuple[tuple[float, Albedo, Albedo], ...] = (
    (1.78, (0.08, 0.10, 0.18), (0.50, 0.10, 0.10)),
    (1.65, (0.10, 0.25, 0.15), (0.70, 0.70, 0.66)),
    (1.85, (0.22, 0.20, 0.18), (0.12, 0.30, 0.52)),
    (1.55, (0.35, 0.12, 0.30), (0.16, 0.16, 0.17)),
    (1.72, (0.06, 0.06, 0.07), (0.75, 0.55, 0.10)),
)
SKIN: tuple[Albedo, ...] = ((0.60, 0.42, 0.33), (0.25, 0.16, 0.11), (0.45, 0.30, 0.20))
POSTERS: tuple[tuple[Size, float, Albedo], ...] = (  # size, height of the centre, albedo
    ((POSTER_THICKNESS_M, 0.70, 1.00), 1.60, (0.75, 0.72, 0.66)),
    ((POSTER_THICKNESS_M, 1.40, 0.90), 1.50, (0.15, 0.35, 0.60)),
    ((POSTER_THICKNESS_M, 2.40, 0.80), 2.20, (0.60, 0.15, 0.12)),
    ((POSTER_THICKNESS_M, 0.85, 2.00), 1.30, (0.20, 0.45, 0.25)),
    ((POSTER_THICKNESS_M, 0.60, 0.60), 1.40, (0.80, 0.70, 0.15)),
)


class Furniture(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One piece: where its middle stands on the floor, the way it faces, and which of its kind's looks it has."""

    name: str
    kind: FurnitureKind
    x_m: float
    y_m: float
    yaw_rad: float
    variant: int = 0

    @property
    def pose(self) -> Pose2:
        """Where the piece stands."""
        return Pose2(x_m=self.x_m, y_m=self.y_m, yaw_rad=self.yaw_rad)


def furniture_solids(piece: Furniture) -> tuple[Solid, ...]:
    """Return the solids of a piece that stands for good: nothing for a chair, see `chair_body`."""
    if piece.kind == "chair":
        return ()
    parts = {"cabinet": _cabinet, "person": _person, "poster": _poster}[piece.kind](piece)
    return tuple(_placed(part, piece.pose) for part in parts)


def chair_body(piece: Furniture) -> Body:
    """Return a chair that can be pushed: a seat, a back and four legs."""
    albedo = CHAIRS[piece.variant % len(CHAIRS)]
    parts = [
        _part(piece, "seat", (0.0, 0.0, 0.45), (0.42, 0.42, 0.03), albedo),
        _part(piece, "back", (-0.195, 0.0, 0.665), (0.03, 0.40, 0.40), albedo),
    ]
    for k, (x, y) in enumerate(((0.19, 0.19), (0.19, -0.19), (-0.19, 0.19), (-0.19, -0.19))):
        parts.append(_part(piece, f"leg_{k}", (x, y, 0.2175), (0.03, 0.03, 0.435), (0.35, 0.35, 0.36)))
    return Body(
        name=piece.name,
        kind="chair",
        pose=piece.pose,
        mass_kg=CHAIR_MASS_KG,
        friction=CHAIR_FRICTION,
        parts=tuple(parts),
    )


def _cabinet(piece: Furniture) -> tuple[Solid, ...]:
    size_m, albedo = CABINETS[piece.variant % len(CABINETS)]
    return (_part(piece, "", (0.0, 0.0, size_m[2] / 2), size_m, albedo),)


def _poster(piece: Furniture) -> tuple[Solid, ...]:
    size_m, z_m, albedo = POSTERS[piece.variant % len(POSTERS)]
    return (_part(piece, "", (0.0, 0.0, z_m), size_m, albedo),)


def _person(piece: Furniture) -> tuple[Solid, ...]:
    height_m, legs, torso = PEOPLE[piece.variant % len(PEOPLE)]
    hip, neck = 0.48 * height_m, 0.83 * height_m
    chin = neck + NECK_M
    skin = SKIN[piece.variant % len(SKIN)]
    if piece.variant % 2:
        lower = [_part(piece, "skirt", (0.0, 0.0, 0.8 * hip), (0.44, 0.44, 1.6 * hip), legs, "cone")]
    else:
        lower = [
            _part(piece, f"leg_{side}", (0.0, y, hip / 2), (0.15, 0.15, hip), legs, "cylinder")
            for side, y in (("left", 0.09), ("right", -0.09))
        ]
    upper = [
        _part(piece, "torso", (0.0, 0.0, (hip + neck) / 2), (0.24, 0.36, neck - hip), torso),
        _part(piece, "arm_left", (0.0, 0.23, (hip + neck) / 2), (0.09, 0.09, neck - hip), torso, "cylinder"),
        _part(piece, "arm_right", (0.0, -0.23, (hip + neck) / 2), (0.09, 0.09, neck - hip), torso, "cylinder"),
        _part(piece, "neck", (0.0, 0.0, neck + NECK_M / 2), (0.11, 0.11, NECK_M), skin, "cylinder"),
        _part(piece, "head", (0.0, 0.0, (chin + height_m) / 2), (0.19, 0.16, height_m - chin), skin, "cylinder"),
    ]
    return (*lower, *upper)


def _part(piece: Furniture, name: str, centre_m: Size, size_m: Size, albedo: Albedo, shape: Shape = "box") -> Solid:
    kind: Kind = piece.kind
    full = f"{piece.name}_{name}" if name else piece.name
    return Solid(name=full, kind=kind, centre_m=centre_m, size_m=size_m, albedo=albedo, shape=shape)


def _placed(part: Solid, pose: Pose2) -> Solid:
    (x_m, y_m), *_ = pose.transform([part.centre_m[:2]])
    return msgspec.structs.replace(
        part, centre_m=(float(x_m), float(y_m), part.centre_m[2]), yaw_rad=pose.yaw_rad + part.yaw_rad
    )
