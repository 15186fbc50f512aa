"""What a drive's file says of its driver."""

from typing import Literal

import msgspec

from adc_bench.dataset.drive_recipe import Behaviour, MissionName
from adc_bench.geometry import Pose2

Ending = Literal["finished", "time", "contact"]


class DriveScript(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Who drove, what and how, and what came of it.

    Attributes:
        number: of the drive in its split; `seed` is its scenario's.
        driver: always the scripted driver, who knows the true pose.
        attempt: how many draws were no drives before this one.
        delay_steps: control steps from the driver's decision to the command.
        ending: `finished` (all driven), `time` (`duration_s` is over) or `contact` (something was hit); None in a plan.
    """

    number: int
    seed: int
    driver: str = "scripted, with the true pose"
    mission: MissionName
    behaviour: Behaviour
    attempt: int
    duration_s: float
    cruise_mps: float
    lateral_mps2: float
    delay_steps: int
    start_pose: Pose2
    ending: Ending | None = None
