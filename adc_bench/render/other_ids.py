"""Ids in the label picture of what is not labelled: above all ids of targets, so that one look tells them apart."""

from collections.abc import Mapping
from enum import IntEnum

from adc_bench.world.solids import Kind


class OtherId(IntEnum):
    """What a pixel of the label picture shows that no label is about."""

    FLOOR = 0  # the road and the hall's floor, but for the crosswalk, which is a target
    TUNNEL = 200
    WALL = 201  # the hall's walls, ceiling and lamps
    GANTRY = 202  # posts, beam, hangers, and the panels' housings
    SIGN_POST = 203  # the vertical signs' posts, feet and the backs of their boards
    FURNITURE = 204  # cabinets, people, posters, chairs
    TAPE = 205
    ROBOT = 206


TARGET_ID_MAX = OtherId.TUNNEL - 1
ID_OF_KIND: Mapping[Kind, OtherId] = {
    "tunnel": OtherId.TUNNEL,
    "wall": OtherId.WALL,
    "gantry": OtherId.GANTRY,
    "panel": OtherId.GANTRY,
    "sign": OtherId.SIGN_POST,
    "cabinet": OtherId.FURNITURE,
    "person": OtherId.FURNITURE,
    "poster": OtherId.FURNITURE,
    "chair": OtherId.FURNITURE,
}
