"""What a split's drives are: how many, how long, which missions, and how well they are driven."""

from collections.abc import Mapping
from typing import Literal, get_args

import msgspec

MissionName = Literal[
    "speed", "signs", "obstacles", "tunnel", "works", "parallel_parking", "bay_parking", "vertical_signs"
]
MISSIONS: tuple[MissionName, ...] = get_args(MissionName)

# clean: no errors. sloppy: a wandering, unsteady, late hand. lane_changes: sloppy, and changes lanes without need.
# recovery: sloppy, starts beside the lane and askew, and is knocked off course. off_road: sloppy, and drives over lines
# on purpose. bump: sloppy, and drives into a box.
Behaviour = Literal["clean", "sloppy", "lane_changes", "recovery", "off_road", "bump"]
BEHAVIOURS: tuple[Behaviour, ...] = get_args(Behaviour)

ON_FREE_ROAD: tuple[Behaviour, ...] = ("clean", "sloppy", "lane_changes", "recovery", "off_road")
SUITING: Mapping[MissionName, tuple[Behaviour, ...]] = {
    "speed": ON_FREE_ROAD,
    "signs": ("clean", "sloppy", "recovery"),
    "obstacles": ("clean", "sloppy", "bump"),
    "tunnel": ("clean", "sloppy", "lane_changes", "recovery"),
    "works": ("clean", "sloppy"),
    "parallel_parking": ("clean", "sloppy"),
    "bay_parking": ("clean", "sloppy"),
    "vertical_signs": ON_FREE_ROAD,
}


class DriveRecipe(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A split's drives: their number, the range of simulated time after which one ends (it may end earlier), and the
    shares of missions and behaviours. A mission's behaviour is drawn among those that suit it (`SUITING`).
    """

    count: int = 4
    duration_s: tuple[float, float] = (20.0, 36.0)
    missions: dict[MissionName, float] = msgspec.field(
        default_factory=lambda: dict.fromkeys(MISSIONS, 1 / len(MISSIONS))
    )
    behaviours: dict[Behaviour, float] = msgspec.field(
        default_factory=lambda: dict.fromkeys(BEHAVIOURS, 1 / len(BEHAVIOURS))
    )

    def __post_init__(self) -> None:
        low_s, high_s = self.duration_s
        if self.count < 1:
            raise ValueError("drives.count must be at least 1")
        if not 1.0 <= low_s <= high_s <= 600.0:
            raise ValueError("drives.duration_s must be two times in 1..600, the shorter first")
        for key, shares in (("missions", self.missions), ("behaviours", self.behaviours)):
            if not (all(share > 0 for share in shares.values()) and abs(sum(shares.values()) - 1) < 1e-9):
                raise ValueError(f"the shares in drives.{key} must be more than 0 and add up to 1")
        for mission in self.missions:
            if not any(behaviour in self.behaviours for behaviour in SUITING[mission]):
                raise ValueError(f"no behaviour in drives.behaviours suits {mission}")
