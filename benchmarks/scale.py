"""A large dataset: rate, shard times, memory over time, bytes, the last step; and what they come to at 10^6 and 10^8.

Usage: python benchmarks/scale.py [--frames 100000] [--size 160x120] [--workers 2] [--frames-per-shard 256]

The sizes in memory (resident, of this process and of each worker) are sampled twice a second; slopes by least squares
over the frames done, the first fifth left out. Everything is written to a folder below --scratch, which goes.
"""

import argparse
import os
import statistics
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import numpy as np
from turns import machine_line, table

from adc_bench.dataset import layout, load_split
from adc_bench.dataset.layout import COCO, MANIFEST, Manifest, to_toml
from adc_bench.dataset.read import load_manifest
from adc_bench.dataset.store import Store
from adc_bench.dataset.write import finish
from adc_bench.generate import Progress, render_split

PAGE_MB = os.sysconf("SC_PAGE_SIZE") / 1e6
SAMPLE_S = 0.5
CORES = 16  # of a machine in the arithmetic
LARGE = (10**6, 10**8)


@dataclass(kw_only=True)
class Watch:
    """What is seen of a run from beside it."""

    begun_s: float = field(default_factory=time.perf_counter)
    frames: int = 0
    rendered_s: float = 0.0  # until the last shard
    shard_s: list[float] = field(default_factory=list)
    parent_mb: list[tuple[int, float]] = field(default_factory=list)  # frames done, size
    worker_mb: dict[int, list[tuple[int, float]]] = field(default_factory=dict)  # by process
    finish_mb: list[float] = field(default_factory=list)
    _spent_s: float = 0.0

    def told(self, now: Progress) -> None:
        spent_s = sum(work.worker_s for work in now.nodes.values())
        if now.frames > self.frames:
            self.shard_s.append(spent_s - self._spent_s)
        self.frames, self._spent_s, self.rendered_s = now.frames, spent_s, time.perf_counter() - self.begun_s
        if now.done == now.total:
            self.finish_mb.append(resident_mb(os.getpid()))

    def sample(self, end: threading.Event) -> None:
        while not end.wait(SAMPLE_S):
            here = resident_mb(os.getpid())
            if self.finish_mb:
                self.finish_mb.append(here)
                continue
            self.parent_mb.append((self.frames, here))
            for worker in workers():
                self.worker_mb.setdefault(worker, []).append((self.frames, resident_mb(worker)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=100_000)
    parser.add_argument("--size", default="160x120")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--frames-per-shard", type=int, default=256)
    parser.add_argument("--scratch", type=Path, help="where the dataset lies meanwhile; the system's place if left out")
    options = parser.parse_args()
    print(machine_line(frames=str(options.frames), size=options.size, workers=str(options.workers)), flush=True)
    width_px, height_px = map(int, options.size.split("x"))
    watch, end = Watch(), threading.Event()
    beside = threading.Thread(target=watch.sample, args=(end,))
    beside.start()
    with tempfile.TemporaryDirectory(dir=options.scratch) as folder:
        try:
            render_split(
                load_split("train"),
                Path(folder) / "out",
                count=options.frames,
                size_px=(width_px, height_px),
                workers=options.workers,
                frames_per_shard=options.frames_per_shard,
                progress=watch.told,
            )
            total_s = time.perf_counter() - watch.begun_s
        finally:
            end.set()
            beside.join()
        store = Store(Path(folder) / "out")
        manifest = load_manifest(store)
        sizes = {name: store.size(name) or 0 for name in (MANIFEST, COCO, *(file.file for file in manifest.files))}
        steps = {coco: last_step_s(store, manifest, coco) for coco in (True, False)}
    print(f"\n{table(*measured(watch, manifest, sizes, steps, total_s))}")
    print(f"\n{table(*arithmetic(watch, manifest, sizes, steps[False], options.workers))}")


def last_step_s(store: Store, manifest: Manifest, coco: bool) -> float:
    """Return the CPU time of the last step, with the COCO file or as very large datasets have it, without."""
    layout.COCO_FRAMES_MAX = manifest.count if coco else 0
    store.write(MANIFEST, to_toml(msgspec.structs.replace(manifest, summary=None)))
    begun_s = time.process_time()
    finish(store, manifest.plan)
    return time.process_time() - begun_s


def measured(
    watch: Watch, manifest: Manifest, sizes: dict[str, int], steps: dict[bool, float], total_s: float
) -> Iterator[Sequence[str]]:
    frames, shard_s = manifest.count, watch.shard_s
    tenth = max(len(shard_s) // 10, 1)
    yield "figure", "value"
    yield "total", f"{total_s:.0f} s"
    yield "frames/s while rendering", f"{frames / watch.rendered_s:.1f}"
    yield "the last step", f"{total_s - watch.rendered_s:.1f} s"
    for coco, step_s in steps.items():
        words = "with COCO" if coco else "without COCO"
        yield f"CPU time of the last step, {words}", f"{step_s:.1f} s ({1e6 * step_s / frames:.0f} us a frame)"
    yield "shards", f"{len(shard_s)} of {manifest.frames_per_shard} frames"
    yield "time of a shard: median, 95 %", f"{statistics.median(shard_s):.2f} s, {np.percentile(shard_s, 95):.2f} s"
    first, last = statistics.median(shard_s[:tenth]), statistics.median(shard_s[-tenth:])
    yield "median of the first and last tenth", f"{first:.2f} s, {last:.2f} s ({last / first:.2f} times)"
    yield "memory of this process", slope_of(watch.parent_mb)
    for number, samples in enumerate(watch.worker_mb.values()):
        yield f"memory of worker {number}", slope_of(samples)
    yield "memory in the last step", f"{watch.finish_mb[0]:.0f} MB before, at most {max(watch.finish_mb):.0f} MB"
    shards = sum(entry.size_bytes for entry in manifest.shards)
    yield "bytes a frame: shards", f"{shards / frames:.0f}"
    for name, size in sizes.items():
        yield f"bytes a frame: {name}", f"{size / frames:.1f}"


def slope_of(samples: Sequence[tuple[int, float]]) -> str:
    """Say the size after a fifth of the samples, the greatest, and the slope over the last four fifths."""
    late = np.array(samples[len(samples) // 5 :])
    if len(late) < 3 or np.ptp(late[:, 0]) == 0:
        return "too short a run"
    slope_kb = np.polyfit(late[:, 0], late[:, 1], 1)[0] * 1e6
    return f"{late[0, 1]:.0f} MB, at most {max(mb for _, mb in samples):.0f} MB, {slope_kb:+.1f} kB per 1,000 frames"


def arithmetic(
    watch: Watch, manifest: Manifest, sizes: dict[str, int], step_s: float, workers: int
) -> Iterator[Sequence[str]]:
    """Yield what the measured rates come to; a core here is a worker, which has a core of its own."""
    frames, core_hz = manifest.count, manifest.count / watch.rendered_s / workers
    shards = sum(entry.size_bytes for entry in manifest.shards) / frames
    yield "at this size and these rates", *(f"{count:.0e} frames".replace("e+0", "e") for count in LARGE)
    yield "core hours", *(f"{count / core_hz / 3600:,.0f}" for count in LARGE)
    yield f"hours on 1 machine of {CORES} cores", *(f"{count / core_hz / 3600 / CORES:,.1f}" for count in LARGE)
    yield f"hours on 32 machines of {CORES} cores", *(f"{count / core_hz / 3600 / CORES / 32:,.2f}" for count in LARGE)
    yield "bytes of shards", *(f"{count * shards / 1e9:,.0f} GB" for count in LARGE)
    yield (
        f"shards of {manifest.frames_per_shard} frames",
        *(f"{-(-count // manifest.frames_per_shard):,}" for count in LARGE),
    )
    plan_bytes = len(to_toml(manifest.plan))
    entry_bytes = (sizes[MANIFEST] - plan_bytes) / manifest.shard_count
    listed = [plan_bytes + entry_bytes * -(-count // manifest.frames_per_shard) for count in LARGE]
    yield "bytes of dataset.toml", *(f"{size / 1e6:,.1f} MB" for size in listed)
    yield "bytes of one COCO file", *(f"{count * sizes[COCO] / frames / 1e9:,.1f} GB" for count in LARGE)
    hours = [count * step_s / frames / 3600 for count in LARGE]
    yield "hours of the last step, on one core, without COCO", *(f"{hour:,.2f}" for hour in hours)


def workers() -> list[int]:
    """Return the processes that were spawned from this one."""
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    return [int(pid) for pid in children if b"spawn_main" in _read(f"/proc/{pid}/cmdline")]


def resident_mb(process: int) -> float:
    fields = _read(f"/proc/{process}/statm").split()
    return int(fields[1]) * PAGE_MB if fields else 0.0


def _read(path: str) -> bytes:
    try:
        return Path(path).read_bytes()
    except (FileNotFoundError, ProcessLookupError):
        return b""  # it has just ended


if __name__ == "__main__":
    main()
