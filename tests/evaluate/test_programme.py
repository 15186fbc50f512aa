"""What the panels order, as half laps and stops."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from adc_bench.evaluate.programme import Programme
from adc_bench.evaluate.suite import Suite, load_suite
from adc_bench.world.categories import PANEL_SIGNS, PanelSign
from adc_bench.world.records import known_records


def test_orders_become_half_laps() -> None:
    programme = Programme(orders=("up", "stop", "right", "left", "up", "end"))
    found = [(half.loop, half.way) for half in programme.half_laps]
    assert found == [("east", "straight"), ("west", "turn"), ("east", "turn"), ("west", "straight")]
    assert not programme.parks


def test_an_order_appears_after_the_loop_before_it() -> None:
    programme = Programme(orders=("up", "stop", "right", "up", "up", "park"))
    assert programme.sign(-1) == "stop" and programme.sign(0) == "up"
    assert [programme.sign(programme.shown_after_loop(half)) for half in range(4)] == ["stop", "up", "up", "park"]
    assert programme.sign(programme.shown_after_stop(1)) == "right"
    assert programme.shown_after_stop(2) == 2
    assert programme.parks


@pytest.mark.parametrize(
    ("orders", "wanted"),
    [
        (("up", "up"), "end or park, last alone"),
        (("up", "end", "up", "end"), "end or park, last alone"),
        (("up", "up", "up", "end"), "an even number of half laps"),
        (("end",), "half laps before the end"),
        (("stop", "up", "up", "end"), "a first order that is not stop: the panels show it before the start"),
        (("up", "stop", "stop", "up", "end"), "one stop at a time"),
        (("right", "up", "end"), "left towards +x (half laps 1, 3, ...) and right towards -x (2, 4, ...) only"),
        (("up", "left", "end"), "left towards +x (half laps 1, 3, ...) and right towards -x (2, 4, ...) only"),
        (("up", "up", "park"), "park in a suite that names a kind of parking, and only there"),
    ],
)
def test_what_is_wrong_with_orders(orders: tuple[PanelSign, ...], wanted: str) -> None:
    assert Programme(orders=orders).fault(None) == wanted


def test_the_bay_is_parked_in_from_the_start_only() -> None:
    assert Programme(orders=("park",)).fault("bay") is None
    assert Programme(orders=("up", "up", "park")).fault("parallel") is None
    told = Programme(orders=("up", "up", "park")).fault("bay")
    assert told == "no half laps before the two-place bay: the lap does not pass it"
    assert Programme(orders=("up", "up", "end")).fault("bay") is not None


@given(st.lists(st.sampled_from(PANEL_SIGNS), max_size=7))
def test_sound_orders_show_every_sign_in_turn(signs: list[PanelSign]) -> None:
    """Whoever drives every half lap and stands at every stop sees all orders, in their order."""
    programme = Programme(orders=tuple(signs))
    if programme.fault(None) and programme.fault("parallel"):
        return
    shown = [0]
    for half in range(len(programme.half_laps)):
        shown.append(programme.shown_after_loop(half))
        if programme.shown_after_stop(shown[-1]) > shown[-1]:
            shown.append(programme.shown_after_stop(shown[-1]))
    assert shown == list(range(len(signs)))


def test_the_shipped_suites_hold_every_order() -> None:
    suites = [load_suite(name) for name in known_records("splits/suites")]
    drives = [suite for suite in suites if isinstance(suite, Suite)]
    assert {sign for suite in drives for trial in suite.trials for sign in trial.orders} == set(PANEL_SIGNS)
