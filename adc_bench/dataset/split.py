"""A split: which seeds and looks its scenarios come from, and how its frames are spread over them."""

import hashlib

import msgspec

from adc_bench.dataset.drive_recipe import DriveRecipe
from adc_bench.world.course import CourseName
from adc_bench.world.layout import Layout
from adc_bench.world.look import ARTWORKS, FLOOR_TEXTURES, LIGHT_SETS, WALL_TEXTURES, LookFamily
from adc_bench.world.records import find_record, load_record
from adc_bench.world.robot import RobotName
from adc_bench.world.salt import salted_seed
from adc_bench.world.setup import RANDOM_LAYOUTS, load_layout


class Split(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A family of scenarios and poses. Scenario k has the seed `seed_first` + k; its frames share one arena.

    `layouts` holds the shares of the scenarios that have each layout: files' names, or words of `RANDOM_LAYOUTS`.
    `signs_share` is the share with vertical signs among those drawn without road-works. `crosswalk_share` is the share
    of poses before the crosswalk, `objects_share` that of poses before signs, boxes or cones where there are any.
    Drive k has the scenario whose seed is the k-th from the end.
    """

    name: str
    seed_first: int
    seed_count: int
    frames: int
    frames_per_scenario: int = 16
    course: CourseName = "a"
    robot: RobotName = "pioneer"
    furniture: bool = True
    layouts: dict[str, float]
    signs_share: float = 0.8
    crosswalk_share: float = 0.5
    objects_share: float = 0.3
    looks: LookFamily
    drives: DriveRecipe = DriveRecipe()
    salted: bool = False  # its seeds follow from a private salt, so that none can make it who has not the salt

    def __post_init__(self) -> None:
        if not (self.seed_count > 0 and self.frames_per_scenario > 0):
            raise ValueError("seed_count and frames_per_scenario must be at least 1")
        if not 0 < self.frames <= self.frames_max:
            raise ValueError(f"frames must lie in 1..{self.frames_max} (seed_count x frames_per_scenario)")
        poses = self.crosswalk_share, self.objects_share
        if not (0 <= self.signs_share <= 1 and min(poses) >= 0 and sum(poses) <= 1):
            raise ValueError("signs_share, crosswalk_share, objects_share and the sum of the last two must lie in 0..1")
        if not (all(share > 0 for share in self.layouts.values()) and abs(sum(self.layouts.values()) - 1) < 1e-9):
            raise ValueError("the shares in layouts must be more than 0 and add up to 1")
        _check_known("looks.floors", self.looks.floors, FLOOR_TEXTURES)
        _check_known("looks.walls", self.looks.walls, WALL_TEXTURES)
        _check_known("looks.light_sets", self.looks.light_sets, tuple(LIGHT_SETS))
        _check_known("looks.artworks", self.looks.artworks, ARTWORKS)
        if not self.looks.light_levels:
            raise ValueError("looks.light_levels is empty")

    @property
    def frames_max(self) -> int:
        """How many frames the seeds allow."""
        return self.seed_count * self.frames_per_scenario

    def seed(self, number: int, salt: bytes | None) -> int:
        """Return the seed of the scenario of this number; a salted split needs its salt."""
        if not self.salted:
            return self.seed_first + number
        assert salt is not None, "load_salt comes first"
        return salted_seed(salt, self.name, number)

    @property
    def sha256(self) -> str:
        """The digest of the values, whatever the file's comments and order."""
        return hashlib.sha256(msgspec.json.encode(self, order="deterministic")).hexdigest()


def load_split(name_or_path: str) -> Split:
    """Return the split of this name (`splits/NAME.toml`) or of this file.

    Raises:
        InputError: it is unknown, its file is broken, or one of its layouts is.
    """
    split = load_record(find_record(name_or_path, "splits"), Split)
    named_layouts(split)
    return split


def named_layouts(split: Split) -> list[Layout]:
    """Return the layouts that a split names, those that are drawn left out.

    Raises:
        InputError: one is unknown, or its file is broken.
    """
    return [load_layout(name) for name in sorted(split.layouts) if name not in RANDOM_LAYOUTS]


def _check_known(key: str, names: tuple[str, ...], known: tuple[str, ...]) -> None:
    if not names:
        raise ValueError(f"{key} is empty")
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"{key} has the unknown name {unknown[0]!r}; known: {', '.join(known)}")
