"""What solids cover: their footprints on the floor and their extents, for many at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.world.solids import Body, Solid

Array = NDArray[np.float64]
CORNERS = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])
ROUND = np.stack([np.cos(np.arange(16) * np.pi / 8), np.sin(np.arange(16) * np.pi / 8)], axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Extents:
    """Solids in the world: `owner` names the thing that each belongs to, `low` and `high` (n, 3) are the corners of
    boxes along the world's axes around them, `centre` (n, 2), `half` (n, 2) and `yaw` (n,) their footprints.
    """

    owner: tuple[str, ...]
    round: NDArray[np.bool_]
    centre: Array
    half: Array
    yaw: Array
    low: Array
    high: Array

    def footprint(self, index: int) -> shapely.Polygon:
        """Return the outline of one solid on the floor: a rectangle, or an ellipse as a polygon of 16 corners."""
        pose = Pose2(x_m=self.centre[index, 0], y_m=self.centre[index, 1], yaw_rad=float(self.yaw[index]))
        outline = ROUND if self.round[index] else CORNERS
        return shapely.Polygon(pose.transform(outline * self.half[index]))


def extents(solids: Sequence[Solid], bodies: Sequence[Body] = ()) -> Extents:
    """Return the extents of solids and of the parts of bodies where these stand at first, in this order."""
    identity = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    parts = [(solid, identity, structure(solid)) for solid in solids]
    parts += [(part, body.pose, body.name) for body in bodies for part in body.parts]
    frame = np.array([(pose.x_m, pose.y_m, pose.yaw_rad) for _, pose, _ in parts])
    local = np.array([(*part.centre_m, *part.size_m, part.yaw_rad, part.pitch_rad) for part, _, _ in parts])
    cos, sin = np.cos(frame[:, 2]), np.sin(frame[:, 2])
    x = frame[:, 0] + cos * local[:, 0] - sin * local[:, 1]
    y = frame[:, 1] + sin * local[:, 0] + cos * local[:, 1]
    yaw, pitch = frame[:, 2] + local[:, 6], local[:, 7]
    length, width, height = (local[:, 3:6] / 2).T
    along = np.abs(np.cos(pitch)) * length + np.abs(np.sin(pitch)) * height
    up = np.abs(np.sin(pitch)) * length + np.abs(np.cos(pitch)) * height
    reach_x = np.abs(np.cos(yaw)) * along + np.abs(np.sin(yaw)) * width
    reach_y = np.abs(np.sin(yaw)) * along + np.abs(np.cos(yaw)) * width
    return Extents(
        owner=tuple(owner for _, _, owner in parts),
        round=np.array([part.shape != "box" for part, _, _ in parts]),
        centre=np.stack([x, y], axis=1),
        half=np.stack([along, width], axis=1),
        yaw=yaw,
        low=np.stack([x - reach_x, y - reach_y, local[:, 2] - up], axis=1),
        high=np.stack([x + reach_x, y + reach_y, local[:, 2] + up], axis=1),
    )


def structure(solid: Solid) -> str:
    """Return the name of the thing that a solid is a part of: `walls`, `gantry` (with the panels), `tunnel`,
    `sign_3`, `person_0` and so on.
    """
    whole = {"wall": "walls", "gantry": "gantry", "panel": "gantry", "tunnel": "tunnel"}
    return whole.get(solid.kind) or "_".join(solid.name.split("_")[:2])
