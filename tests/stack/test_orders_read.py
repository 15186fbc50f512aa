"""The orders as a state machine, by hand-made pictures of the panels."""

from collections.abc import Iterable

import msgspec
import numpy as np
import pytest
from driven_robot import mission
from panel_pictures import panel

from adc_bench.api import Mission
from adc_bench.stack.orders import OrdersState, leading_on, look, take_order
from adc_bench.world.categories import PANEL_SIGNS, PanelSign


def shown(task: Mission, state: OrdersState, signs: Iterable[PanelSign | None]) -> tuple[OrdersState, list[PanelSign]]:
    """Return the state after these pictures, and the orders that were taken."""
    taken = []
    for sign in signs:
        state, order = take_order(task, look(state, panel(sign)))
        taken += [order] if order else []
    return state, taken


LEADING_ON = [{"up", "left"}, {"up", "right"}, {"up", "left"}, {"up", "right"}, {"end"}]


@pytest.mark.parametrize("sign", PANEL_SIGNS)
@pytest.mark.parametrize("crosswalk", range(5))
def test_every_sign_at_every_crosswalk(crosswalk: int, sign: PanelSign) -> None:
    before = OrdersState(crosswalk=crosswalk)
    assert leading_on(mission(), before) == LEADING_ON[crosswalk]
    state, taken = shown(mission(), before, [sign, sign])
    if sign in LEADING_ON[crosswalk]:
        assert (taken, state.crosswalk, state.over) == ([sign], crosswalk + 1, sign == "end")
        assert state.reading.sign is None
    else:
        assert (taken, state.crosswalk, state.over) == ([], crosswalk, False)


@pytest.mark.parametrize("kind", ["parallel", "bay"])
def test_who_parks_is_sent_to_it_by_the_last_sign(kind: str) -> None:
    task = msgspec.structs.replace(mission(laps=0), parking=kind)
    state, taken = shown(
        task, OrdersState(), ["stop", "stop", "end", "end", "up", "up", "park", "park", "park", "park"]
    )
    assert (taken, state.crosswalk, state.over) == (["park"], 1, True)


@pytest.mark.parametrize("other", ["left", "stop", None])
def test_a_sign_that_flickers_is_no_order(other: PanelSign | None) -> None:
    state, taken = shown(mission(), OrdersState(), ["up", other] * 20)
    assert (taken, state.crosswalk) == ([], 0)


def test_a_stop_holds_until_another_sign_is_seen_twice() -> None:
    state, taken = shown(mission(), OrdersState(crosswalk=1), ["stop"] * 10 + ["right"])
    assert (taken, state.reading.sign) == ([], "stop")
    assert shown(mission(), state, ["right"])[1] == ["right"]


def test_whatever_is_shown_there_are_no_more_orders_than_crosswalks() -> None:
    rng = np.random.default_rng(7)
    for _ in range(20):
        signs = rng.choice([*PANEL_SIGNS, None], size=300).repeat(2)
        state, taken = shown(mission(), OrdersState(), signs)
        assert len(taken) == state.crosswalk <= 5
        assert state.over and taken[-1] == "end"
