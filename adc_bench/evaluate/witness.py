"""What a run knows and a submission must not: told to a witness alone, for drivers that are lent a layer of truth."""

from dataclasses import dataclass
from typing import Literal

from adc_bench.geometry import Pose2
from adc_bench.world.frame import Label

Privilege = Literal["pose", "detections"]


@dataclass(frozen=True, kw_only=True)
class Truth:
    """The truth of one observation: the robot's pose, and by camera the labels of the pictures that arrived with it."""

    step: int
    pose: Pose2
    labels: dict[str, tuple[Label, ...]]


class Witness:
    """Keeps the truth of the last observations, for the run is one step ahead of the driver."""

    def __init__(self, privilege: Privilege) -> None:
        self.privilege = privilege
        self._known: dict[int, Truth] = {}

    def hear(self, truth: Truth) -> None:
        """Take note of the truth of the next observation."""
        self._known = {step: known for step, known in self._known.items() if step >= truth.step - 1}
        self._known[truth.step] = truth

    def tell(self, step: int) -> Truth:
        """Return the truth of one of the last two observations."""
        return self._known[step]
