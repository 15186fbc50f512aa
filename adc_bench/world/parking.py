"""Where to park: the places' poses, and the paint of the two-place bay beside the start straight (adc.md 7)."""

import math
from typing import Literal

import msgspec
import numpy as np
import shapely

from adc_bench.geometry import Pose2

ParkingKind = Literal["parallel", "bay"]


class BaySpec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Figures of the two-place bay; part of the rules. Outline and P are CONDE's and AUTOMEC's, closed on all sides;
    position, gap and the dashed separator CONDE's. The size of the P is our own.
    """

    near_x_m: float = -1.46  # the outer edge nearer to the crosswalk
    gap_m: float = 0.25  # from the outer line's outer edge to the bay's outer edge
    length_m: float = 1.60  # along the road, over the lines
    depth_m: float = 1.05  # across, over the lines
    line_width_m: float = 0.05
    dash_length_m: float = 0.20
    dash_period_m: float = 0.35
    letter_height_m: float = 0.45
    letter_width_m: float = 0.26
    letter_stroke_m: float = 0.06


class ParkingPlace(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A place to park: its middle and the direction in which a robot stands there nose first, and its free size.

    The parallel bay is measured to its lines' centres, the places of the two-place bay between their lines.
    """

    name: str
    pose: Pose2
    length_m: float  # along the pose
    width_m: float


def bay_places(bay: BaySpec, kerb_y_m: float) -> tuple[ParkingPlace, ParkingPlace]:
    """Return the two places, the one nearer to the crosswalk first. The bay lies beyond `kerb_y_m`, on its -y side."""
    near, far = (
        ParkingPlace(
            name=name,
            pose=Pose2(
                x_m=bay.near_x_m - (index + 0.5) * bay.length_m / 2 + (0.5 - index) * -bay.line_width_m / 2,
                y_m=kerb_y_m - bay.gap_m - bay.depth_m / 2,
                yaw_rad=-math.pi / 2,
            ),
            length_m=bay.depth_m - 2 * bay.line_width_m,
            width_m=(bay.length_m - 3 * bay.line_width_m) / 2,
        )
        for index, name in enumerate(("bay_near", "bay_far"))
    )
    return near, far


def bay_paint(bay: BaySpec, kerb_y_m: float) -> tuple[shapely.Polygon, ...]:
    """Return the bay's outline, the dashes between its places, and a P in each place, read from the road."""
    x1, y1 = bay.near_x_m, kerb_y_m - bay.gap_m
    x0, y0 = x1 - bay.length_m, y1 - bay.depth_m
    line_m = bay.line_width_m
    inside = shapely.box(x0 + line_m, y0 + line_m, x1 - line_m, y1 - line_m)
    middle_m = (x0 + x1) / 2
    dashes = [
        shapely.box(
            middle_m - line_m / 2, max(start_m - bay.dash_length_m, y0 + line_m), middle_m + line_m / 2, start_m
        )
        for start_m in np.arange(y1 - line_m, y0 + line_m, -bay.dash_period_m)
    ]
    letters = [_letter_p(bay, place.pose) for place in bay_places(bay, kerb_y_m)]
    return (shapely.box(x0, y0, x1, y1).difference(inside), *dashes, *letters)


def _letter_p(bay: BaySpec, pose: Pose2) -> shapely.Polygon:
    """Return a P whose top points along the pose, in the middle of the place."""
    half_m = bay.letter_stroke_m / 2
    height_m, width_m = bay.letter_height_m - 2 * half_m, bay.letter_width_m - 2 * half_m
    top_m, left_m, bowl_m = height_m / 2, width_m / 2, height_m / 4
    turn = np.linspace(np.pi / 2, -np.pi / 2, 17)
    straight_m = max(width_m - bowl_m, 0.0)
    bowl = [
        (top_m - bowl_m + bowl_m * math.sin(angle), left_m - straight_m - bowl_m * math.cos(angle)) for angle in turn
    ]
    strokes = shapely.MultiLineString(
        [[(-top_m, left_m), (top_m, left_m)], [(top_m, left_m), *bowl, (top_m - 2 * bowl_m, left_m)]]
    )
    letter = strokes.buffer(half_m, cap_style="square", join_style="mitre")
    return shapely.transform(letter, pose.transform)
