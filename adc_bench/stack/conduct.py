"""When to go: what a driver does with the panels' signs. Pure steps, told the pose at which the command will act."""

from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

from adc_bench.api import LaserScan
from adc_bench.geometry import Pose2
from adc_bench.stack.panel import PanelReading, read_panel
from adc_bench.stack.pilots import Pilot
from adc_bench.world.categories import SignCategory
from adc_bench.world.frame import Detections
from adc_bench.world.robot import Motion

State = TypeVar("State")
Progress = TypeVar("Progress")


class Conduct(Pilot[State], Protocol[State]):
    """A pilot that is shown the panels and the laser's scans."""

    def looks(self, state: State) -> bool:
        """Return whether the next picture by the panels' camera matters."""
        ...

    def look(self, state: State, pose: Pose2, detections: Detections) -> State:
        """Return the state after a picture by the panels' camera, taken at this pose."""
        ...

    def report(self, state: State) -> SignCategory | None:
        """Return the vertical sign to be reported now, or None."""
        ...

    def see(self, state: State, pose: Pose2, scan: LaserScan) -> State:
        """Return the state after a scan of the laser, taken at this pose."""
        ...


@dataclass(frozen=True, kw_only=True)
class ArrowProgress(Generic[Progress]):
    """What the panel was read to say, and how far the pilot is."""

    reading: PanelReading
    progress: Progress


@dataclass(frozen=True, kw_only=True)
class AfterArrow(Generic[Progress]):
    """Waits for the green arrow; after that a pilot drives."""

    pilot: Pilot[Progress]

    def start(self) -> ArrowProgress[Progress]:
        """Return the state before the arrow."""
        return ArrowProgress(reading=PanelReading(), progress=self.pilot.start())

    def looks(self, state: ArrowProgress[Progress]) -> bool:
        """Return whether the arrow is still awaited."""
        return state.reading.sign != "up"

    def look(self, state: ArrowProgress[Progress], pose: Pose2, detections: Detections) -> ArrowProgress[Progress]:
        """Return the state after a picture of the panel."""
        return replace(state, reading=read_panel(state.reading, detections))

    def report(self, state: ArrowProgress[Progress]) -> SignCategory | None:
        """Return None: no vertical signs are read."""
        return None

    def see(self, state: ArrowProgress[Progress], pose: Pose2, scan: LaserScan) -> ArrowProgress[Progress]:
        """Return the state: nothing is looked for with the laser."""
        return state

    def steer(
        self, state: ArrowProgress[Progress], pose: Pose2, motion: Motion
    ) -> tuple[ArrowProgress[Progress], Motion]:
        """Return the next state and the command."""
        if self.looks(state):
            return state, Motion()
        progress, command = self.pilot.steer(state.progress, pose, motion)
        return replace(state, progress=progress), command
