"""What the panels order in a run: the one place where a trial's signs become what the referee expects.

Both panels show the same sign. They show stop until the start; then the trial's orders, one after the other:

    up                a half lap: straight over the crosswalk and round the next loop as the lap goes
    left, right       a half lap the other way round: left into the S-road towards +x, right towards -x
    stop              stand in the stop zone before the crosswalk; then the next order appears
    end               the run is over when the crosswalk is passed
    park              stand in a free place; the run is over then

An order appears when the robot passes the middle of the loop before the crosswalk at which it applies.
"""

from dataclasses import dataclass
from functools import cached_property

import msgspec

from adc_bench.world.categories import PanelSign
from adc_bench.world.parking import ParkingKind
from adc_bench.world.route import Loop, Way

DRIVING: tuple[PanelSign, ...] = ("up", "left", "right")
TURN: dict[Loop, PanelSign] = {"east": "left", "west": "right"}


class Trial(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One set-up of a suite: the panels' orders, and what stands on the road.

    `layout` is a layout file's name or path, or a word of `RANDOM_LAYOUTS`.
    """

    orders: tuple[PanelSign, ...]
    layout: str = "open"


@dataclass(frozen=True, kw_only=True)
class HalfLap:
    """From crosswalk to crosswalk round a loop: as the lap does, or with a turn at first and the other way round."""

    loop: Loop
    way: Way


@dataclass(frozen=True, kw_only=True)
class Programme:
    """A trial's orders. Before the start `shown` is -1; later it counts the orders that have appeared."""

    orders: tuple[PanelSign, ...]

    @cached_property
    def half_laps(self) -> tuple[HalfLap, ...]:
        """The half laps that are ordered."""
        signs = [sign for sign in self.orders if sign in DRIVING]
        return tuple(
            HalfLap(loop=loop_of(half), way="straight" if sign == "up" else "turn") for half, sign in enumerate(signs)
        )

    @property
    def parks(self) -> bool:
        """Whether it ends with parking."""
        return self.orders[-1] == "park"

    @property
    def only_parks(self) -> bool:
        """Whether there is no half lap to drive."""
        return not self.half_laps

    def sign(self, shown: int) -> PanelSign:
        """Return what the panels show."""
        return "stop" if shown < 0 else self.orders[shown]

    def shown_after_loop(self, half: int) -> int:
        """Return which order appears in the middle of a half lap's loop: the one after that half lap's own."""
        return [index for index, sign in enumerate(self.orders) if sign in DRIVING][half] + 1

    def shown_after_stop(self, shown: int) -> int:
        """Return which order appears when a stop is over; itself if it is no stop."""
        return shown + (self.sign(shown) == "stop")

    def fault(self, parking: ParkingKind | None) -> str | None:
        """Return what is wrong with the orders, or None."""
        half_laps, last = len(self.half_laps), self.orders[-1:]
        turns = [sign for sign in self.orders if sign in DRIVING]
        checks = (
            (last in (("end",), ("park",)) and not {"end", "park"} & set(self.orders[:-1]), "end or park, last alone"),
            (half_laps % 2 == 0, "an even number of half laps"),
            (half_laps > 0 or self.orders == ("park",), "half laps before the end"),
            (self.orders[:1] != ("stop",), "a first order that is not stop: the panels show it before the start"),
            ("stopstop" not in "".join(self.orders), "one stop at a time"),
            (
                all(sign in ("up", TURN[loop_of(half)]) for half, sign in enumerate(turns)),
                "left towards +x (half laps 1, 3, ...) and right towards -x (2, 4, ...) only",
            ),
            (
                (parking is not None) == (last == ("park",)),
                "park in a suite that names a kind of parking, and only there",
            ),
            (parking != "bay" or not half_laps, "no half laps before the two-place bay: the lap does not pass it"),
        )
        return next((wanted for good, wanted in checks if not good), None)


def loop_of(half: int) -> Loop:
    """Return the loop of the half lap of this number, from 0."""
    return "east" if half % 2 == 0 else "west"
