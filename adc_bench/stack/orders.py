"""The panels' orders as a state machine: which signs lead on over the next crosswalk, and what follows from each.

A mission is a row of crosswalks, numbered from 0 at the start; behind each but the last lies a half lap, round the loop
towards +x first and then in turns. At a crosswalk the robot waits for a sign that leads on from there: before a half
lap one that sends it straight or into the S-road, at the last crosswalk the one that ends the run or has it park. Stop
leads nowhere, and neither does a sign that cannot be meant there. A transition is a crosswalk more: there are at most
2 laps + 1.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from adc_bench.api import Mission
from adc_bench.stack.panel import PanelReading, read_panel
from adc_bench.world.categories import PanelSign
from adc_bench.world.frame import Detections
from adc_bench.world.route import Loop

TURNS: Mapping[Loop, PanelSign] = {"east": "left", "west": "right"}


@dataclass(frozen=True, kw_only=True)
class OrdersState:
    """The number of the crosswalk ahead, what its panel was read to say so far, and whether the last order is given."""

    crosswalk: int = 0
    reading: PanelReading = field(default_factory=PanelReading)
    over: bool = False


def loop_behind(crosswalk: int) -> Loop:
    """Return the loop that lies behind a crosswalk."""
    return "east" if crosswalk % 2 == 0 else "west"


def leading_on(mission: Mission, state: OrdersState) -> frozenset[PanelSign]:
    """Return the signs that lead on from the crosswalk ahead."""
    if state.over:
        return frozenset()
    if state.crosswalk < 2 * mission.laps:
        return frozenset({"up", TURNS[loop_behind(state.crosswalk)]})
    return frozenset({"park" if mission.parking else "end"})


def look(state: OrdersState, detections: Detections) -> OrdersState:
    """Return the state after one more picture of the crosswalk's panel."""
    return OrdersState(crosswalk=state.crosswalk, reading=read_panel(state.reading, detections), over=state.over)


def take_order(mission: Mission, state: OrdersState) -> tuple[OrdersState, PanelSign | None]:
    """Return the state beyond the crosswalk and the sign that leads there; the same state and None as yet without."""
    sign = state.reading.sign
    if sign not in leading_on(mission, state):
        return state, None
    return OrdersState(crosswalk=state.crosswalk + 1, over=sign in ("end", "park")), sign
