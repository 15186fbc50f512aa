"""Draw docs/pictures/drives.png: the paths that the scripted drivers drive, mission by mission, over the course.

Usage: python scripts/drives_picture.py [--split train] [--drives 60] [--out docs/pictures/drives.png]

Simulates without rendering: about a minute. Prints a line for each drive.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adc_bench.dataset import load_split
from adc_bench.dataset.drive_recipe import BEHAVIOURS, MISSIONS, Behaviour, MissionName
from adc_bench.dataset.driving.floor import taken_floor
from adc_bench.dataset.driving.plan import draw_drive
from adc_bench.generate.drives import Simulated, simulate
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig

matplotlib.use("Agg")
COLOURS: dict[Behaviour, str] = dict(
    zip(BEHAVIOURS, ("tab:green", "tab:blue", "tab:purple", "tab:red", "tab:brown", "black"), strict=True)
)
COLUMNS = 2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--split", default="train")
    parser.add_argument("--drives", type=int, default=60)
    parser.add_argument("--out", type=Path, default=Path("docs/pictures/drives.png"))
    options = parser.parse_args()
    split, driven = load_split(options.split), []
    for number in range(options.drives):
        scenario, plan = draw_drive(split, number, SensorRig())
        driven.append((scenario, simulate(scenario, plan)))
        print(_line(driven[-1][1]))
    figure = Figure(figsize=(13, 14), layout="constrained")
    axes = figure.subplots(len(MISSIONS) // COLUMNS, COLUMNS)
    for mission, place in zip(MISSIONS, axes.ravel(), strict=True):
        _draw(place, mission, [(s, d) for s, d in driven if d.script.mission == mission])
    figure.savefig(options.out, dpi=75)


def _line(driven: Simulated) -> str:
    script, last = driven.script, driven.rows[-1]
    hits = sorted({hit.with_name for row in driven.rows for hit in row.contacts})
    return (
        f"{script.number:3} {script.mission:17}{script.behaviour:13}{script.ending:9}{last.time_s:6.2f} s "
        f"{script.cruise_mps:.2f} m/s {', '.join(hits)}"
    )


def _draw(axes: Axes, mission: MissionName, driven: list[tuple[Scenario, Simulated]]) -> None:
    axes.set_title(f"{mission} ({len(driven)})", fontsize=10)
    axes.set(xlim=(-9.6, 9.6), ylim=(-4.6, 4.2), aspect="equal", facecolor="0.2", xticks=[], yticks=[])
    for mark in driven[0][0].course.paint if driven else ():
        axes.fill(*mark.exterior.xy, facecolor="0.75") if not mark.interiors else _outline(axes, mark)
    for scenario, drive in driven:
        colour = COLOURS[drive.script.behaviour]
        for part in shapely.get_parts(taken_floor(scenario, scenario.bodies)):
            if part.geom_type == "Polygon" and mission not in ("speed", "signs"):
                axes.fill(*part.exterior.xy, facecolor="tab:orange", alpha=0.35)
        path = np.array([row.pose_world_robot.translation_m[:2] for row in drive.rows])
        axes.plot(*path.T, color=colour, linewidth=0.9)
        axes.plot(*path[0], "o", color=colour, markersize=3)
    shown = sorted({drive.script.behaviour for _, drive in driven}, key=BEHAVIOURS.index)
    handles = [axes.plot([], [], color=COLOURS[name], label=name)[0] for name in shown]
    axes.legend(handles=handles, loc="upper center", fontsize=7, ncols=6, facecolor="0.85")


def _outline(axes: Axes, mark: shapely.Polygon) -> None:
    for ring in (mark.exterior, *mark.interiors):
        axes.plot(*ring.xy, color="0.75", linewidth=1.5)


if __name__ == "__main__":
    main()
