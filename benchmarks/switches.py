"""How long it takes to change the arena: loading another scenario, and its first picture.

Usage: python benchmarks/switches.py [--switches 40]

Every scenario has everything in it (tunnel, boxes, road-works, signs, furniture) and a look of its own; it is drawn
beforehand. The first one also warms the process up and is told apart: from making the renderer to its first picture.
"""

import argparse
import statistics
from time import perf_counter

from arenas import arena, rig, stops
from turns import machine_line, table

from adc_bench.render.renderer import ArenaRenderer
from adc_bench.world.scenario import Scenario

SIZES = ((320, 240), (640, 480))
WANTED_S = 0.5


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--switches", type=int, default=40)
    options = parser.parse_args()
    print(machine_line(), flush=True)
    rows = [("size", "switches", "median s", "90 % below s", "worst s", "wanted s", "first frame s")]
    for size in SIZES:
        first_s, found = measure(size, options.switches)
        median, high, worst = statistics.median(found), statistics.quantiles(found, n=10)[-1], max(found)
        name = f"{size[0]}x{size[1]}"
        rows.append((name, str(len(found)), *(f"{s:.2f}" for s in (median, high, worst, WANTED_S, first_s))))
    print(f"\n{table(*rows)}")


def measure(size: tuple[int, int], switches: int) -> tuple[float, list[float]]:
    """Return the time to the first picture, and that of every switch that followed."""
    sensor_rig = rig(*size)
    scenarios = [arena(number, sensor_rig) for number in range(switches + 1)]
    start_s = perf_counter()
    renderer = ArenaRenderer(sensor_rig)
    first_s = switch(renderer, scenarios[0]) - start_s
    times_s = []
    for scenario in scenarios[1:]:
        start_s = perf_counter()
        times_s.append(switch(renderer, scenario) - start_s)
    return first_s, times_s


def switch(renderer: ArenaRenderer, scenario: Scenario) -> float:
    """Load the scenario, take a picture of it, and return the clock then."""
    renderer.load(scenario)
    renderer.raw("road", next(stops(scenario)))
    return perf_counter()


if __name__ == "__main__":
    main()
