"""The label categories, in the order of their ids (from 1)."""

from typing import Literal, get_args

SignCategory = Literal[
    "sign_danger",
    "sign_dip",
    "sign_cattle",
    "sign_narrows",
    "sign_parking",
    "sign_speed60",
    "sign_hospital",
    "sign_crosswalk",
    "sign_turn_left",
    "sign_headlights",
    "sign_roundabout",
    "sign_bus_lane",
]
Category = Literal[
    "crosswalk",
    "panel_up",
    "panel_left",
    "panel_right",
    "panel_stop",
    "panel_park",
    "panel_end",
    SignCategory,
    "box",
    "cone",
]
CATEGORIES: tuple[str, ...] = get_args(Category)
CATEGORY_ID = {name: index for index, name in enumerate(CATEGORIES, start=1)}

PanelSign = Literal["up", "left", "right", "stop", "park", "end"]
PANEL_SIGNS: tuple[PanelSign, ...] = get_args(PanelSign)
SIGNS: tuple[SignCategory, ...] = get_args(SignCategory)
