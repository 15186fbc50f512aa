"""How an arena looks: light, surfaces and exposure, as a record drawn from a family of looks."""

import math
from collections.abc import Mapping
from typing import Annotated, Literal

import msgspec
import numpy as np

LightLevel = Literal["dark", "dim", "normal", "bright"]

# Mean illuminance on the open floor in lux, drawn log-uniformly in the range; 200:1 from end to end.
LIGHT_LEVELS: Mapping[LightLevel, tuple[float, float]] = {
    "dark": (8.0, 20.0),
    "dim": (30.0, 90.0),
    "normal": (150.0, 450.0),
    "bright": (800.0, 1600.0),
}


class LightSet(msgspec.Struct, frozen=True, kw_only=True):
    """A way of lighting the hall: ranges from which a look is drawn."""

    colour_temperature_k: tuple[float, float]
    flood_azimuth_rad: tuple[float, float]  # where the stronger floodlight stands, seen from the arena's centre
    flood_elevation_rad: tuple[float, float]
    flood_share: tuple[float, float]  # of both floodlights in the floor's illuminance; the rest is diffuse
    lamp_share: tuple[float, float]  # of the diffuse part: ceiling lamps in place of an even sky


def _set(
    kelvin: tuple[float, float],
    azimuth_deg: tuple[float, float],
    flood: tuple[float, float],
    lamps: tuple[float, float],
) -> LightSet:
    azimuth = (math.radians(azimuth_deg[0]), math.radians(azimuth_deg[1]))
    elevation = (math.radians(20), math.radians(60))
    return LightSet(
        colour_temperature_k=kelvin,
        flood_azimuth_rad=azimuth,
        flood_elevation_rad=elevation,
        flood_share=flood,
        lamp_share=lamps,
    )


LIGHT_SETS: Mapping[str, LightSet] = {
    "warm_hall": _set((2700, 3500), (0, 60), (0.0, 0.3), (0.3, 0.9)),
    "neutral_hall": _set((3800, 4600), (90, 150), (0.0, 0.4), (0.3, 0.9)),
    "window_left": _set((5200, 6500), (60, 90), (0.3, 0.7), (0.0, 0.4)),
    "window_right": _set((5000, 6000), (-100, -60), (0.3, 0.7), (0.0, 0.4)),
    "floodlight_east": _set((3000, 4200), (-20, 0), (0.4, 0.75), (0.1, 0.5)),
    "evening_hall": _set((2900, 4000), (150, 180), (0.1, 0.5), (0.2, 0.8)),
    "window_north": _set((5500, 7000), (-150, -120), (0.2, 0.65), (0.0, 0.4)),
    "floodlight_west": _set((3300, 4400), (180, 210), (0.3, 0.7), (0.1, 0.6)),
    "overcast_hall": _set((4500, 6200), (-60, -20), (0.1, 0.6), (0.1, 0.7)),
}

# The second floodlight: its share of both, and how far round the hall it stands from the first.
SECOND_SHARE = (0.1, 0.5)
SECOND_TURN_RAD = (math.radians(70), math.radians(170))

# Gloss of each floor covering: how much of a clear coat's mirror image it keeps, from a dull to a freshly waxed one.
FLOOR_GLOSS: Mapping[str, tuple[float, float]] = {
    "black_carpet": (0.0, 0.0),
    "grey_carpet": (0.0, 0.0),
    "charcoal_vinyl": (0.15, 0.6),
    "worn_vinyl": (0.1, 0.45),
    "rubber_mat": (0.05, 0.25),
    "speckled_rubber": (0.1, 0.35),
    "felt": (0.0, 0.0),
    "painted_board": (0.1, 0.5),
    "scuffed_linoleum": (0.15, 0.55),
}
FLOOR_TEXTURES = tuple(FLOOR_GLOSS)
WALL_TEXTURES = (
    "plaster",
    "brick",
    "panels",
    "banners",
    "slats",
    "ladder_bars",
    "stripes",
    "concrete",
    "posters",
    "curtain",
    "shelves",
    "blocks",
)
# Styles in which panels and signs are drawn.
ARTWORKS = ("standard", "bold", "slim", "barbed", "tall", "enamel", "broad", "weathered", "stout")


class LookFamily(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The looks that a split or suite may use."""

    floors: tuple[str, ...]
    walls: tuple[str, ...]
    light_sets: tuple[str, ...]
    light_levels: tuple[LightLevel, ...] = ("dark", "dim", "normal", "bright")
    artworks: tuple[str, ...] = ("standard",)


class Flood(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A floodlight far away, or daylight through a window: where from, and its share of the floor's illuminance."""

    azimuth_rad: float
    elevation_rad: float
    share: float


class Look(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One look, complete: what the renderer needs beside the geometry. Stored with the data.

    Attributes:
        floods: at most two floodlights; the rest of the light is diffuse and from the ceiling's lamps.
        lamp_share: of that rest, what the lamps give in place of an even sky.
        panel_luminance: of a white pixel, relative to a white floor under 300 lux.
        artwork: the style in which panels and signs are drawn.
        floor_gloss: share of a clear coat's mirror image that the floor shows, 0 for carpet.
        line_wear: share of the paint that is gone where the lines are worn most.
        dirt: how dusty and scuffed the floor is, 0 for clean to 1.
    """

    floor: str
    wall: str
    texture_seed: int
    light_set: str
    light_level: LightLevel
    illuminance_lux: float
    colour_temperature_k: float
    floods: Annotated[tuple[Flood, ...], msgspec.Meta(max_length=2)]
    lamp_share: float
    line_albedo: float
    panel_luminance: float
    artwork: str
    exposure_bias_ev: float
    floor_gloss: float = 0.0
    line_wear: float = 0.0
    dirt: float = 0.0

    @property
    def flood_share(self) -> float:
        """The floodlights' share of the light on open floor."""
        return sum(flood.share for flood in self.floods)

    @property
    def look_id(self) -> str:
        """A short name: surfaces, light, texture seed and artwork."""
        return f"{self.floor}-{self.wall}-{self.light_set}-{self.light_level}-{self.texture_seed}-{self.artwork}"


def draw_look(family: LookFamily, rng: np.random.Generator, light_level: LightLevel | None = None) -> Look:
    """Draw a look from the family, at the given light level if one is given."""
    light_set = str(rng.choice(np.array(family.light_sets)))
    level: LightLevel = family.light_levels[int(rng.integers(len(family.light_levels)))]
    level = light_level or level
    ranges = LIGHT_SETS[light_set]
    low, high = LIGHT_LEVELS[level]
    floor = str(rng.choice(np.array(family.floors)))
    return Look(
        floor=floor,
        wall=str(rng.choice(np.array(family.walls))),
        texture_seed=int(rng.integers(2)),
        light_set=light_set,
        light_level=level,
        illuminance_lux=float(np.exp(rng.uniform(np.log(low), np.log(high)))),
        colour_temperature_k=float(rng.uniform(*ranges.colour_temperature_k)),
        floods=_draw_floods(ranges, rng),
        lamp_share=float(rng.uniform(*ranges.lamp_share)),
        line_albedo=float(rng.uniform(0.65, 0.9)),
        panel_luminance=float(rng.uniform(0.6, 1.4)),
        exposure_bias_ev=float(rng.uniform(-0.5, 0.5)),
        floor_gloss=float(rng.uniform(*FLOOR_GLOSS[floor])),
        line_wear=float(rng.uniform(0.05, 0.6)),
        dirt=float(rng.uniform(0.0, 1.0)),
        artwork=str(rng.choice(np.array(family.artworks))),
    )


def _draw_floods(ranges: LightSet, rng: np.random.Generator) -> tuple[Flood, Flood]:
    """Draw the two floodlights, the stronger one first."""
    share, second = rng.uniform(*ranges.flood_share), rng.uniform(*SECOND_SHARE)
    azimuth = rng.uniform(*ranges.flood_azimuth_rad)
    turn = rng.uniform(*SECOND_TURN_RAD) * (1 if rng.random() < 0.5 else -1)
    return (
        Flood(
            azimuth_rad=float(azimuth),
            elevation_rad=float(rng.uniform(*ranges.flood_elevation_rad)),
            share=float(share * (1 - second)),
        ),
        Flood(
            azimuth_rad=float(azimuth + turn),
            elevation_rad=float(rng.uniform(*ranges.flood_elevation_rad)),
            share=float(share * second),
        ),
    )
