"""Equal inputs give equal bytes: pictures, labels and physics across processes and numbers of rasteriser threads.

`python tests/proofs/test_same_bytes.py (physics | pictures | drive)` prints the digests of one process.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from hashlib import sha256

import msgspec
import numpy as np
import pytest

from adc_bench.dataset import load_split
from adc_bench.dataset.sampling import draw_frame, draw_scenario
from adc_bench.render import ArenaRenderer
from adc_bench.sim import Simulation
from adc_bench.world.arena import ArenaSpec, Tunnel
from adc_bench.world.course import CourseSpec
from adc_bench.world.layout import BoxPlace, Layout, Works
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import Motion, RobotParams
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import set_up
from adc_bench.world.streams import stream

LOOKS = LookFamily(floors=("worn_vinyl",), walls=("brick",), light_sets=("window_left",))
# From the start straight on: a tape to tear where the road-works lead off to the left, then a box to push.
CRASH = Layout(
    name="crash",
    tunnel=Tunnel(start_s_m=10.0, length_m=2.0),
    boxes=(BoxPlace(x_m=4.3, y_m=-2.5),),
    works=Works(left=((2.0, -1.6), (2.8, -0.9)), right=((1.9, -3.05), (2.9, -2.1))),
    signs=True,
)
STEPS, SCENARIOS, FRAMES = 80, 6, 8
THREADS = {"no thread": "0", "one thread": "1", "as it comes": None, "as it comes, again": None}


def crash_scenario() -> Scenario:
    return set_up(
        name="crash",
        seed=7,
        look=draw_look(LOOKS, stream(7, "look"), "normal"),
        panel_sign="left",
        layout=CRASH,
        course=CourseSpec(),
        arena=ArenaSpec(),
        robot=RobotParams(),
        rig=SensorRig(),
    )


def physics(sim: Simulation) -> Iterator[bytes]:
    """Yield after every control step all that the simulation tells."""
    for k in range(STEPS):
        sim.advance(1.5, 0.05 * np.sin(k / 5))
        readings, bodies = sim.read_sensors(), sim.body_poses()
        told = [
            *(getattr(readings.encoders, field) for field in ("time_s", "left_ticks", "right_ticks")),
            *(getattr(readings.imu, field) for field in ("time_s", "yaw_rate_radps", "acceleration_x_mps2")),
            *([readings.laser.ranges_m] if readings.laser else []),
            *(pose.matrix() for pose in (sim.pose3_world_robot(), *bodies.values())),
        ]
        words = repr((sim.state(), sorted(bodies), sorted(sim.torn_tapes()), sim.take_contacts()))
        yield b"".join(np.ascontiguousarray(array).tobytes() for array in told) + words.encode()


def physics_digests() -> list[str]:
    scenario = crash_scenario()
    return [digest(step) for step in physics(Simulation(scenario, scenario.course.lap.pose(0.9)))]


def drive_digests() -> list[str]:
    """What the camera sees on the same drive, delivered."""
    scenario = crash_scenario()
    sim, renderer = Simulation(scenario, scenario.course.lap.pose(0.9)), ArenaRenderer(scenario.rig)
    renderer.load(scenario)
    found = []
    for step in physics(sim):
        renderer.place(sim.body_poses(), sim.torn_tapes())
        state = sim.state()
        motion = Motion(v_mps=state.v_mps, omega_radps=state.omega_radps)
        jpeg = renderer.picture("road", sim.pose3_world_robot(), time_s=sim.time_s, motion=motion)
        found.append(digest(step + jpeg))
    return found


def picture_digests() -> list[str]:
    """Frames of a split with their labels: raw pictures, files, truth."""
    split, rig = load_split("train"), SensorRig()
    renderer, found = ArenaRenderer(rig), []
    for number in range(SCENARIOS):
        scenario = draw_scenario(split, number, rig)
        renderer.load(scenario)
        for index in range(number * split.frames_per_scenario, number * split.frames_per_scenario + FRAMES):
            plan = draw_frame(split, scenario, index)
            renderer.set_panel(plan.panel_sign)
            colour, ids = renderer.raw(plan.camera, plan.pose_world_robot)
            frame = renderer.frame(index, plan.camera, plan.pose_world_robot, motion=plan.motion)
            found += [digest(colour.tobytes() + ids.tobytes()), digest(frame.jpeg + msgspec.json.encode(frame.labels))]
    return found


def digest(data: bytes) -> str:
    return sha256(data).hexdigest()


DIGESTS = {"physics": physics_digests, "pictures": picture_digests, "drive": drive_digests}


def in_a_process(what: str, threads: str | None) -> list[str]:
    environment = {name: value for name, value in os.environ.items() if name != "LP_NUM_THREADS"}
    if threads is not None:
        environment["LP_NUM_THREADS"] = threads
    done = subprocess.run(
        [sys.executable, __file__, what], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return list(json.loads(done.stdout))


@pytest.mark.slow
@pytest.mark.parametrize("what", DIGESTS)
def test_every_process_and_every_number_of_threads_gives_the_same_bytes(what: str) -> None:
    found = {name: in_a_process(what, threads) for name, threads in THREADS.items()}
    expected = found.pop("as it comes")
    assert len(set(expected)) == len(expected)  # the digests see what they are of
    for name, digests in found.items():
        wrong = [k for k, (a, b) in enumerate(zip(digests, expected, strict=True)) if a != b]
        assert not wrong, f"{name}: differs from {wrong[0]} on"


@pytest.mark.slow
def test_the_drive_moves_things() -> None:
    scenario = crash_scenario()
    sim = Simulation(scenario, scenario.course.lap.pose(0.9))
    before = sim.body_poses()
    for _ in physics(sim):
        pass
    moved = {name for name, pose in sim.body_poses().items() if not np.allclose(pose.matrix(), before[name].matrix())}
    assert "box_0" in moved and sim.torn_tapes()


if __name__ == "__main__":
    sys.stdout.write(json.dumps(DIGESTS[sys.argv[1]]()))
