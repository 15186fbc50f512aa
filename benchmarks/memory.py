"""Whether memory stays flat: resident size of this process over many frames and over many changes of the arena.

Usage: python benchmarks/memory.py [--frames 10000] [--switches 200]

Frames come with their labels, as a dataset holds them. Every scenario has everything in it. A fifth as much of each
comes before as a warm-up. Slopes by least squares over all samples; textures that come and go move the size up and
down, so the greatest sizes of both halves are told too.
"""

import argparse
import itertools
import resource
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from arenas import arena, rig, stops
from turns import machine_line, table

from adc_bench.render.renderer import ArenaRenderer

SIZE_PX = (320, 240)
PAGE_MB = resource.getpagesize() / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--switches", type=int, default=200)
    options = parser.parse_args()
    print(machine_line(), flush=True)
    renderer = ArenaRenderer(rig(*SIZE_PX))
    rows = [("over", "resident MB at first", "greatest in the first half", "in the second", "slope")]
    for name, work, count, unit, scale in (
        ("frames", frames(renderer), options.frames, "kB a frame", 1000),
        ("switches", switches(renderer), options.switches, "MB a switch", 1),
    ):
        sizes = resident_over(work, count)
        slope = np.polyfit(np.arange(count), sizes, 1)[0] * scale
        peaks = sizes[0], max(sizes[: count // 2]), max(sizes[count // 2 :])
        rows.append((f"{count} {name}", *(f"{mb:.1f}" for mb in peaks), f"{slope:+.4f} {unit}"))
    print(f"\n{table(*rows)}")


def frames(renderer: ArenaRenderer) -> Iterator[None]:
    """Take frames round the lap of one scenario."""
    scenario = arena(0, renderer.rig)
    renderer.load(scenario)
    for index, pose in enumerate(stops(scenario)):
        renderer.frame(index, "road", pose)
        yield


def switches(renderer: ArenaRenderer) -> Iterator[None]:
    """Load one scenario after the other, and take a frame of each."""
    for number in itertools.count(1):
        scenario = arena(number, renderer.rig)
        renderer.load(scenario)
        renderer.frame(0, "road", next(stops(scenario)))
        yield


def resident_over(work: Iterator[None], count: int) -> list[float]:
    """Return the resident size in MB after each of so many pieces of work, a fifth as many before them uncounted."""
    for _ in itertools.islice(work, max(count // 5, 2)):
        pass
    return [resident_mb() for _ in itertools.islice(work, count)]


def resident_mb() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE_MB


if __name__ == "__main__":
    main()
