import pytest

from adc_bench.api import Agent
from adc_bench.errors import UsageError
from adc_bench.reference import BUILT_IN, Layers
from adc_bench.stack.edge_localizer import EdgeLocalizer


def test_the_built_in_names() -> None:
    assert set(BUILT_IN) == {"reference", "thesis", "odometry-only", "lane-follower", "stand-still"}


def test_stand_still_is_an_agent_and_has_no_options() -> None:
    assert isinstance(BUILT_IN["stand-still"]({}), Agent)
    with pytest.raises(UsageError) as caught:
        BUILT_IN["stand-still"]({"speed_mps": "1"})
    assert "no options: this agent has none" in str(caught.value)


def test_who_steers_by_no_pose_is_lent_none() -> None:
    with pytest.raises(UsageError) as caught:
        BUILT_IN["lane-follower"]({}, Layers(localizer=lambda mission: EdgeLocalizer(mission=mission)))
    assert "lane-follower, which steers by no pose" in str(caught.value)


def test_an_unknown_option_is_named_with_the_known_ones() -> None:
    with pytest.raises(UsageError) as caught:
        BUILT_IN["thesis"]({"sped_mps": "1"})
    assert caught.value.exit_code == 2
    assert "--set sped_mps=1" in str(caught.value)
    assert "one of weights, speed_mps, controller" in str(caught.value)


def test_a_controller_that_is_none_is_refused_with_those_that_are() -> None:
    with pytest.raises(UsageError) as caught:
        BUILT_IN["thesis"]({"controller": "lqr"})
    assert "found:      'lqr'" in str(caught.value)
    assert "one of pid, linearisation" in str(caught.value)


@pytest.mark.parametrize("name", sorted(BUILT_IN))
def test_each_is_an_agent(name: str) -> None:
    assert isinstance(BUILT_IN[name]({}), Agent)


@pytest.mark.parametrize("value", ["fast", "0", "-1", "nan", "inf", ""])
def test_a_speed_that_is_no_number_above_0_is_refused(value: str) -> None:
    with pytest.raises(UsageError) as caught:
        BUILT_IN["odometry-only"]({"speed_mps": value})
    assert f"found:      {value!r}" in str(caught.value)
    assert "a number above 0, such as 1.0" in str(caught.value)
