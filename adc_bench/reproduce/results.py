"""All that the experiments found."""

from dataclasses import dataclass

from adc_bench.reproduce.approach import Approach
from adc_bench.reproduce.avoidance import Avoidance
from adc_bench.reproduce.filters import Estimate
from adc_bench.reproduce.laps import Lap
from adc_bench.reproduce.settings import Controller, Settings


@dataclass(frozen=True, kw_only=True)
class Results:
    """The experiments' records.

    Attributes:
        laps: by `lap_name`, in the settings' order.
        reckoned: the first lap from the encoders alone, by each robot; the first robot is that of the laps.
        filtered: the first lap with simulated landmarks.
        pixels: a lap from pixels.
    """

    settings: Settings
    laps: dict[str, Lap]
    reckoned: tuple[Estimate, ...]
    filtered: Estimate
    pixels: Estimate
    approach: Approach
    avoidances: tuple[Avoidance, ...]


def lap_name(controller: Controller, speed_mps: float) -> str:
    """Return the name of a lap."""
    return f"{controller}-{speed_mps:.1f}"
