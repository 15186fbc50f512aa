"""Suites of recordings: drives for a localiser, pictures for a detector; both made of a split of the suite's own."""

from typing import ClassVar

import msgspec

from adc_bench.api import Kind
from adc_bench.dataset.driving.plan import DrivePlan, draw_drive
from adc_bench.dataset.split import Split
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig


class RecordedSuite(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"):
    """What both have; nothing recorded is kept: every run makes what it shows, the same for everybody."""

    name: str
    split: Split
    ranked: bool = True  # whether its results may stand on the leaderboard
    salt_sha256: str | None = None  # digest of the private salt that a hidden suite's split is drawn with

    def __post_init__(self) -> None:
        if self.split.salted != (self.salt_sha256 is not None):
            raise ValueError("split.salted must be true where there is a salt_sha256, and only there")

    def scenario_name(self, seed: int) -> str:
        """Return the name of a seed's run."""
        return f"{self.name}-{seed}"


class LocalizationSuite(RecordedSuite, frozen=True, kw_only=True, tag="localizer"):
    """Drives by a script that knows the true pose. A run is a drive of the split, told step by step as on the road."""

    kind: ClassVar[Kind] = "localizer"

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of the split's drives, in order; of a hidden suite before the salt is mixed in."""
        last = self.split.seed_first + self.split.seed_count - 1
        return tuple(last - number for number in range(self.split.drives.count))

    def drawn(self, seed: int, rig: SensorRig, salt: bytes | None) -> tuple[Scenario, DrivePlan]:
        """Return the arena and the plan of a seed's drive; a hidden suite needs its salt.

        Raises:
            InputError: the arena cannot be, or no drive of the mission fits into it.
        """
        return draw_drive(self.split, self.seeds.index(seed), rig, salt)


class DetectionSuite(RecordedSuite, frozen=True, kw_only=True, tag="detector"):
    """Pictures, each for itself. A run is `pictures` of them, in some arenas that no other run has."""

    kind: ClassVar[Kind] = "detector"
    pictures: int

    def __post_init__(self) -> None:
        super().__post_init__()
        whole = self.pictures > 0 and self.pictures % self.split.frames_per_scenario == 0
        if not whole or self.split.frames % self.pictures:
            raise ValueError("pictures must be a multiple of frames_per_scenario, and frames one of pictures")

    @property
    def seeds(self) -> tuple[int, ...]:
        """The first arena's seed of each run; of a hidden suite before the salt is mixed in."""
        arenas = self.pictures // self.split.frames_per_scenario
        runs = self.split.frames // self.pictures
        return tuple(self.split.seed_first + arenas * run for run in range(runs))
