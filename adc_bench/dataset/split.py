"""A split: which seeds and looks its scenarios come from, and how its frames are spread over them."""

import hashlib

import msgspec

from adc_bench.world.look import FLOOR_TEXTURES, LIGHT_SETS, WALL_TEXTURES, LookFamily
from adc_bench.world.records import find_record, load_record


class Split(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A family of scenarios and poses. Scenario k has the seed `seed_first` + k; its frames share one arena.

    `tunnel_share` is the share of scenarios with a tunnel, `crosswalk_share` that of poses before the crosswalk.
    """

    name: str
    seed_first: int
    seed_count: int
    frames: int
    frames_per_scenario: int = 16
    tunnel_share: float = 0.25
    crosswalk_share: float = 0.5
    looks: LookFamily

    def __post_init__(self) -> None:
        if not (self.seed_count > 0 and self.frames_per_scenario > 0):
            raise ValueError("seed_count and frames_per_scenario must be at least 1")
        if not 0 < self.frames <= self.frames_max:
            raise ValueError(f"frames must lie in 1..{self.frames_max} (seed_count x frames_per_scenario)")
        if not (0 <= self.tunnel_share <= 1 and 0 <= self.crosswalk_share <= 1):
            raise ValueError("tunnel_share and crosswalk_share must lie in 0..1")
        _check_known("looks.floors", self.looks.floors, FLOOR_TEXTURES)
        _check_known("looks.walls", self.looks.walls, WALL_TEXTURES)
        _check_known("looks.light_sets", self.looks.light_sets, tuple(LIGHT_SETS))
        if not self.looks.light_levels:
            raise ValueError("looks.light_levels is empty")

    @property
    def frames_max(self) -> int:
        """How many frames the seeds allow."""
        return self.seed_count * self.frames_per_scenario

    @property
    def sha256(self) -> str:
        """The digest of the values, whatever the file's comments and order."""
        return hashlib.sha256(msgspec.json.encode(self)).hexdigest()


def load_split(name_or_path: str) -> Split:
    """Return the split of this name (`splits/NAME.toml`) or of this file.

    Raises:
        InputError: it is unknown, or its file is broken.
    """
    return load_record(find_record(name_or_path, "splits"), Split)


def _check_known(key: str, names: tuple[str, ...], known: tuple[str, ...]) -> None:
    if not names:
        raise ValueError(f"{key} is empty")
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"{key} has the unknown name {unknown[0]!r}; known: {', '.join(known)}")
