"""Frames per second of `adc-bench render` beside the raw render loop of the same scenes, in the same run.

Usage: python benchmarks/render.py [--frames 128] [--repeats 3] [--workers 2]

Raw: `take_picture` and reading the picture back, nothing else, arenas loaded beforehand. Render: everything up to the
finished folder (arenas, pictures, noise, JPEG, labels, HDF5, COCO) in one process, and with workers for comparison.
Each size runs in a process of its own; medians over the repeats, raw and render taking turns.
"""

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from adc_bench.dataset.layout import Manifest

START_S = perf_counter()
SIZES = ((320, 240), (640, 480))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=128)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(tuple(map(int, options.one.split("x"))), options)))
        return
    print("| size | raw frames/s | render frames/s | render / raw | with workers | first frame s | peak MB |")
    print("|---|---|---|---|---|---|---|")
    for width_px, height_px in SIZES:
        size = f"{width_px}x{height_px}"
        reply = subprocess.run(
            [sys.executable, __file__, *sys.argv[1:], "--one", size], check=True, capture_output=True, text=True
        )
        found = json.loads(reply.stdout)
        print(
            f"| {size} | {found['raw']:.1f} | {found['render']:.1f} | {found['render'] / found['raw']:.0%} "
            f"| {found['workers']:.1f} ({options.workers}) | {found['first_s']:.2f} | {found['peak_mb']:.0f} |"
        )


def measure(size_px: tuple[int, int], options: argparse.Namespace) -> dict[str, float]:
    """Return medians of the rates, the time from start to first frame, and the peak memory of this process."""
    from adc_bench.dataset import load_split
    from adc_bench.generate import plan_dataset, render_split

    split = load_split("val")
    plan = plan_dataset(split, options.frames, size_px)
    raw_rate(plan, 1)
    first_s = perf_counter() - START_S
    raw, render, shared = [], [], []
    for _ in range(options.repeats):
        raw.append(raw_rate(plan, options.frames))
        for rates, workers in ((render, 1), (shared, options.workers)):
            with tempfile.TemporaryDirectory() as folder:
                start_s = perf_counter()
                render_split(split, Path(folder) / "out", frames=options.frames, size_px=size_px, workers=workers)
                rates.append(options.frames / (perf_counter() - start_s))
    return {
        "raw": statistics.median(raw),
        "render": statistics.median(render),
        "workers": statistics.median(shared),
        "first_s": first_s,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def raw_rate(plan: "Manifest", frames: int) -> float:
    """Return raw frames/s over the first frames of the plan; loading an arena is not counted."""
    from adc_bench.dataset.sampling import draw_frame, draw_scenario, scenario_number
    from adc_bench.generate import process_renderer
    from adc_bench.world.sensors import SensorRig

    rig = SensorRig(cameras=plan.cameras)
    renderer = process_renderer(rig)
    spent_s, loaded = 0.0, None
    for index in range(frames):
        number = scenario_number(plan.split, index)
        if number != loaded:
            loaded, scenario = number, draw_scenario(plan.split, number, rig)
            renderer.load(scenario)
        frame = draw_frame(plan.split, scenario, index)
        start_s = perf_counter()
        renderer.raw(frame.camera, frame.pose_world_robot)
        spent_s += perf_counter() - start_s
    return frames / spent_s


if __name__ == "__main__":
    main()
