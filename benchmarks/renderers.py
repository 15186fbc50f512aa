"""One arena, one camera, several renderers, each in a process of its own, taking turns: ms a frame and their ratios.

Usage: python benchmarks/renderers.py [--rounds 7] [--frames 24]

Every frame moves the camera and reads back colours and labels. fast: ours, light and shadows of the scenario. picture:
the same with lens, exposure, noise and JPEG, as a camera delivers it. trivial and default: SAPIEN's packs on our meshes
and textures, default with two lights that cast shadows. MuJoCo (EGL): an equal scene, two lights that cast shadows, in
its own environment (scripts/peers.sh); once with shadow maps and samples like the others', once with its own defaults.
first frame s: from the start of the process, imports and arena included. Medians over the rounds, ratios too.
"""

import argparse
import statistics
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from arenas import arena, rig
from scene_file import write_scene
from turns import HERE, Worker, machine_line, ratio, table, take_turns

from adc_bench.world.sensors import Lens

SIZES = ((320, 240), (640, 480))
PEER = HERE.parent / ".peers" / "mujoco" / "bin" / "python"
# What is promised, as how many times longer than the other: (longer, shorter, at most | at least, figure).
WANTED = (
    ("fast", "trivial", "at most", 1.6),
    ("default", "fast", "at least", 5.0),
    ("MuJoCo", "fast", "at least", 2.5),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--frames", type=int, default=24)
    options = parser.parse_args()
    print(machine_line(), flush=True)
    times, ratios = [("size", "renderer", "ms a frame", "first frame s")], [("size", "ratio", "measured", "wanted")]
    for size in SIZES:
        name = f"{size[0]}x{size[1]}"
        ready_s, found = measure(size, options.rounds, options.frames)
        times += [
            (name, who, f"{1000 * statistics.median(each):.1f}", f"{ready_s[who]:.2f}") for who, each in found.items()
        ]
        ratios += [
            (name, f"{longer} / {shorter}", f"{ratio(found[longer], found[shorter]):.2f}", f"{bound} {figure}")
            for longer, shorter, bound, figure in WANTED
            if longer in found
        ]
    print(f"\n{table(*times)}\n\n{table(*ratios)}")


def measure(size: tuple[int, int], rounds: int, frames: int) -> tuple[dict[str, float], dict[str, list[float]]]:
    """Return by renderer: seconds to the first frame; seconds a frame, one figure a round."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        workers = [stack.enter_context(worker) for worker in start(size, Path(folder))]
        return {worker.name: worker.ready_s for worker in workers}, take_turns(workers, rounds, frames)


def start(size: tuple[int, int], folder: Path) -> Iterator[Worker]:
    """Start the renderers one after the other."""
    programs = HERE / "workers"
    width, height = map(str, size)
    for name, program, mode in (
        ("fast", "ours.py", "raw"),
        ("picture", "ours.py", "picture"),
        ("trivial", "sapien_pack.py", "trivial"),
        ("default", "sapien_pack.py", "default"),
    ):
        yield Worker(name, sys.executable, str(programs / program), width, height, mode)
    if not PEER.exists():
        print("MuJoCo is left out: run scripts/peers.sh first", flush=True)
        return
    sensor_rig = rig(*size, lens=Lens(k1=0.0, k2=0.0))
    write_scene(arena(0, sensor_rig), sensor_rig.cameras[0], folder)
    for name, mode in (("MuJoCo", "equal"), ("MuJoCo as it comes", "defaults")):
        command = (str(PEER), str(programs / "mujoco_arena.py"), width, height, str(folder), mode)
        yield Worker(name, *command, env={"MUJOCO_GL": "egl"})


if __name__ == "__main__":
    main()
