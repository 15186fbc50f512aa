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

from adc_bench.dataset import load_split
from adc_bench.dataset.layout import write_file
from adc_bench.detector import Detector, shipped_weights
from adc_bench.detector.decode import DecodeConfig
from adc_bench.detector.evaluation.figures import INKS, draw_approach, png
from adc_bench.detector.evaluation.operating import CROSSWALK
from adc_bench.geometry import Pose2
from adc_bench.render import ArenaRenderer
from adc_bench.world.arena import ArenaSpec
from adc_bench.world.course import Course
from adc_bench.world.look import draw_look
from adc_bench.world.picture import decode_picture
from adc_bench.world.robot import ROBOTS
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream

FIRST_M, LAST_M = -6.0, 5.0
SEED_FIRST = 3_700_000
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
    detector = Detector.load(options.weights, config=DecodeConfig(score_min=0.01))
    places_m = np.arange(FIRST_M, LAST_M + options.step / 2, options.step)
    scores: dict[str, dict[str, np.ndarray]] = {camera.name: {} for camera in rig.cameras}
    print("| arena | camera | found from | to | share found between | found behind it |\n|---|---|---|---|---|---|")
    for name, scenario in arenas(rig):
        renderer.load(scenario)
        for camera in scores:
            found = np.array([best_score(renderer, detector, camera, scenario, x_m) for x_m in places_m])
            scores[camera][name] = found
            print(row(name, camera, places_m, found))
    write_file(options.out, png(lambda figure: draw_approach(figure, places_m, scores, THRESHOLD), INKS["light"]))


def arenas(rig: SensorRig) -> Iterator[tuple[str, Scenario]]:
    split = load_split("test")
    for number, (level, layout) in enumerate(RUNS):
        seed = SEED_FIRST + number
        yield (
            f"{level}{', tunnel' if layout != 'open' else ''}",
            set_up(
                name=f"approach-{number}",
                seed=seed,
                look=draw_look(split.looks, stream(seed, "look"), level),
                panel_sign="up",
                layout=draw_layout(layout, Course(), stream(seed, "layout")),
                course=Course().spec,
                arena=ArenaSpec(),
                robot=ROBOTS[split.robot],
                rig=rig,
            ),
        )


def best_score(renderer: ArenaRenderer, detector: Detector, camera: str, scenario: Scenario, x_m: float) -> float:
    """The surest crosswalk's score in the picture taken where the robot's origin is at x."""
    place = Pose2(x_m=float(x_m), y_m=-scenario.course.spec.lane_outer_radius_m, yaw_rad=0.0)
    frame = renderer.frame(round(1000 * (x_m - FIRST_M)), camera, place.to_pose3())
    found = detector(decode_picture(frame.jpeg))
    return float(found.scores[found.category_ids == CROSSWALK].max(initial=0.0))


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
