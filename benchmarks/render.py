"""Frames per second of `adc-bench render` beside the raw render loop of the same scenes, in the same run.

Usage: python benchmarks/render.py [--frames 256] [--repeats 3] [--workers 2] [--sizes 320x240 640x480]

Raw: `take_picture` and reading the picture back, nothing else, arenas loaded beforehand. Render: everything up to the
finished folder (arenas, pictures, noise, JPEG, labels, HDF5, COCO) in this process, and with workers of their own,
whose start counts. Each size runs in a process of its own; medians over the repeats, of the ratios too, raw, render and
workers taking turns. CPU times (user and system, all threads) hardly depend on what else the machine does.
"""

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter, process_time
from typing import TYPE_CHECKING

from turns import machine_line, table

if TYPE_CHECKING:
    from adc_bench.dataset.layout import Manifest

START_S = perf_counter()
HEAD: tuple[str, ...] = (
    "size",
    "raw frames/s",
    "render frames/s",
    "render / raw",
    "workers frames/s",
    "workers / render",
    "raw CPU ms",
    "render CPU ms",
    "bytes a frame",
    "first frame s",
    "peak MB",
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=256)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--sizes", nargs="+", default=["320x240", "640x480"])
    parser.add_argument("--one", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        width_px, height_px = map(int, options.one.split("x"))
        print(json.dumps(measure((width_px, height_px), options)))
        return
    print(machine_line(), flush=True)
    rows = [HEAD]
    for size in options.sizes:
        command = [sys.executable, __file__, *sys.argv[1:], "--one", size]
        reply = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
        rows.append(_row(size, json.loads(reply.stdout.splitlines()[-1])))
    print(f"\n{options.frames} frames, {options.repeats} repeats, {options.workers} workers\n\n{table(*rows)}")


def _row(size: str, found: dict[str, float]) -> tuple[str, ...]:
    return (
        size,
        f"{found['raw']:.1f}",
        f"{found['render']:.1f}",
        f"{found['render_share']:.0%}",
        f"{found['workers']:.1f}",
        f"{found['workers_share']:.2f}",
        f"{found['raw_cpu_ms']:.1f}",
        f"{found['render_cpu_ms']:.1f}",
        f"{found['frame_bytes']:,.0f}",
        f"{found['first_s']:.2f}",
        f"{found['peak_mb']:.0f}",
    )


def measure(size_px: tuple[int, int], options: argparse.Namespace) -> dict[str, float]:
    """Return medians of the rates (1/s), the time from start to first frame, and the peak memory of this process."""
    from adc_bench.dataset import load_split
    from adc_bench.generate import render_split
    from adc_bench.generate.plan import plan_dataset

    split, frames = load_split("val"), options.frames
    plan = plan_dataset(split, frames, size_px)
    raw_loop(plan, 1)
    first_s, sizes = perf_counter() - START_S, []

    def render(workers: int) -> tuple[float, float]:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder) / "out"
            shard = max(1, min(plan.frames_per_shard, frames // options.workers))
            spent = _timed(
                lambda: render_split(
                    split, root, count=frames, size_px=size_px, workers=workers, frames_per_shard=shard
                )
            )
            sizes.append(sum(path.stat().st_size for path in root.rglob("*") if path.is_file()) / frames)
            return spent

    turns = [(raw_loop(plan, frames), render(1), render(options.workers)) for _ in range(options.repeats)]
    raw, alone, shared = (statistics.median(frames / turn[k][0] for turn in turns) for k in range(3))
    return {
        "raw": raw,
        "render": alone,
        "workers": shared,
        "render_share": statistics.median(turn[0][0] / turn[1][0] for turn in turns),
        "workers_share": statistics.median(turn[1][0] / turn[2][0] for turn in turns),
        "raw_cpu_ms": statistics.median(turn[0][1] for turn in turns) / frames * 1000,
        "render_cpu_ms": statistics.median(turn[1][1] for turn in turns) / frames * 1000,
        "frame_bytes": statistics.median(sizes),
        "first_s": first_s,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def _timed(work: Callable[[], object]) -> tuple[float, float]:
    """Return the seconds that some work takes, of the clock and of this process' CPU time."""
    start_s, cpu_s = perf_counter(), process_time()
    work()
    return perf_counter() - start_s, process_time() - cpu_s


def raw_loop(plan: "Manifest", frames: int) -> tuple[float, float]:
    """Return the seconds, clock and CPU, of the raw loop over the plan's first frames, less the arenas' loading."""
    from adc_bench.dataset.sampling import draw_frame, draw_scenario, scenario_number
    from adc_bench.generate.plan import plan_renderer

    renderer = plan_renderer(plan)
    spent_s, spent_cpu_s, loaded = 0.0, 0.0, None
    for index in range(frames):
        number = scenario_number(plan.split, index)
        if number != loaded:
            loaded, scenario = number, draw_scenario(plan.split, number, renderer.rig)
            renderer.load(scenario)
        frame = draw_frame(plan.split, scenario, index)
        renderer.set_panel(frame.panel_sign)
        clock_s, cpu_s = _timed(partial(renderer.raw, frame.camera, frame.pose_world_robot))
        spent_s, spent_cpu_s = spent_s + clock_s, spent_cpu_s + cpu_s
    return spent_s, spent_cpu_s


if __name__ == "__main__":
    main()
