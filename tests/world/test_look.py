"""Looks: two floodlights within their set's ranges, gloss by the kind of floor, all of it stored and read back."""

import msgspec
import pytest

from adc_bench.world.look import FLOOR_GLOSS, LIGHT_SETS, Flood, Look, LookFamily, draw_look
from adc_bench.world.streams import stream

FAMILY = LookFamily(
    floors=tuple(FLOOR_GLOSS), walls=("brick",), light_sets=("window_left", "floodlight_west"), light_levels=("normal",)
)


def test_two_floodlights_share_what_their_set_allows() -> None:
    for seed in range(60):
        look = draw_look(FAMILY, stream(seed, "look"))
        ranges = LIGHT_SETS[look.light_set]
        first, second = look.floods
        assert ranges.flood_share[0] <= look.flood_share <= ranges.flood_share[1] < 1
        assert first.share >= second.share > 0
        for flood in look.floods:
            assert ranges.flood_elevation_rad[0] <= flood.elevation_rad <= ranges.flood_elevation_rad[1]


def test_only_smooth_floors_are_glossy() -> None:
    for seed in range(60):
        look = draw_look(FAMILY, stream(seed, "look"))
        low, high = FLOOR_GLOSS[look.floor]
        assert low <= look.floor_gloss <= high
        if "carpet" in look.floor or look.floor == "felt":
            assert look.floor_gloss == 0
        assert 0 < look.line_wear < 1 and 0 <= look.dirt <= 1


def test_a_look_is_read_back_as_it_was_stored() -> None:
    look = draw_look(FAMILY, stream(1, "look"))
    assert msgspec.json.decode(msgspec.json.encode(look), type=Look) == look


def test_a_third_floodlight_is_refused() -> None:
    look = draw_look(FAMILY, stream(1, "look"))
    three = msgspec.structs.replace(look, floods=(Flood(azimuth_rad=0.0, elevation_rad=0.5, share=0.1),) * 3)
    with pytest.raises(msgspec.ValidationError, match=r"length <= 2.*floods"):
        msgspec.json.decode(msgspec.json.encode(three), type=Look)
