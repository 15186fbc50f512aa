"""With what score a detector finds the crosswalk as the robot drives up to it and over it: the thesis' figure.

Usage: python benchmarks/approach.py --out FILE.png [--weights FILE] [--step 0.1]

The robot drives along the starting lane, from 6 m before the crosswalk's middle to 5 m behind it, in arenas of the test
family on seeds that no split has: one in each light, and one with the tunnel over the crosswalk. At each place both
cameras take a picture. A place counts as found where the surest crosswalk has the operating threshold's score.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from adc_bench.dataset.layout import write_file
from adc_bench.detector import Detector, shipped_weights
from adc_bench.detector.decode import DecodeConfig
from adc_bench.detector.evaluation.figures import draw_approach
from adc_bench.pages.drawing import INKS, png
from adc_bench.render import ArenaRenderer
from adc_bench.reproduce.approach import LEAST_SCORE, approach_arena, approach_places_m, best_scores
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig

THRESHOLD = DecodeConfig().score_min
RUNS = (("dark", "open"), ("dim", "open"), ("normal", "open"), ("bright", "open"), ("dim", "crosswalk_tunnel"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--weights", type=Path, default=shipped_weights())
    parser.add_argument("--step", type=float, default=0.1, help="metres between two places")
    options = parser.parse_args()
    rig = SensorRig()
    renderer = ArenaRenderer(rig)
    detector = Detector.load(options.weights, config=DecodeConfig(score_min=LEAST_SCORE))
    places_m = np.array(approach_places_m(options.step))
    scores: dict[str, dict[str, np.ndarray]] = {camera.name: {} for camera in rig.cameras}
    print("| arena | camera | found from | to | share found between | found behind it |\n|---|---|---|---|---|---|")
    for name, scenario in arenas(rig):
        renderer.load(scenario)
        for camera in scores:
            found = np.array([*best_scores(renderer, detector, camera, scenario, tuple(places_m.tolist()))])
            scores[camera][name] = found
            print(row(name, camera, places_m, found))
    write_file(options.out, png(lambda figure: draw_approach(figure, places_m, scores, THRESHOLD), INKS["light"]))


def arenas(rig: SensorRig) -> Iterator[tuple[str, Scenario]]:
    for number, (level, layout) in enumerate(RUNS):
        name = f"{level}{', tunnel' if layout != 'open' else ''}"
        yield name, approach_arena(number, level, layout, rig)


def row(name: str, camera: str, places_m: np.ndarray, scores: np.ndarray) -> str:
    """Where the crosswalk is found; behind it, where the camera cannot see it, there is nothing to be found."""
    hits = places_m[(scores >= THRESHOLD) & (places_m < 0)]
    behind = int(((scores >= THRESHOLD) & (places_m > 0.5)).sum())
    if len(hits) == 0:
        return f"| {name} | {camera} | - | - | - | {behind} |"
    between = scores[(places_m >= hits[0]) & (places_m <= hits[-1])] >= THRESHOLD
    return f"| {name} | {camera} | {hits[0]:.1f} m | {hits[-1]:.1f} m | {between.mean():.2f} | {behind} |"


if __name__ == "__main__":
    main()
