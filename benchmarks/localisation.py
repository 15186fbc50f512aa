"""How well the built-in localisers know their place: laps with the true pose, the same recording for each of them.

Usage: python benchmarks/localisation.py [--seeds 2000000 2000001 ...] [--speeds 1.0 1.5 2.0]
       [--layouts open random_tunnel] [--laps 2] [--thesis]

Run k takes the k-th seed, and speeds and layouts in turn. Arenas have the looks of the validation split, which no suite
has; the driver follows a line that wanders 3 cm about the lane's middle. A row a run: position RMSE, 95th percentile
and maximum in millimetres, heading RMSE in degrees, mean NEES (ideally 3), share inside the 95 % region, and CPU a step
without the detector in milliseconds. `--thesis` adds the thesis' localiser, with the shipped detector's weights.
"""

import argparse
import itertools
import math
import time
from collections.abc import Iterator

import cv2
import numpy as np

from adc_bench.api import Observation, Picture
from adc_bench.dataset import load_split
from adc_bench.evaluate.metrics import COVERED_NEES, nees, position_errors_m, rms
from adc_bench.evaluate.rules import RULES
from adc_bench.geometry import Pose2, wrap_array_rad, wrap_rad
from adc_bench.render import ArenaRenderer
from adc_bench.reproduce.laps import COURSE, START, mission
from adc_bench.sim import Simulation
from adc_bench.stack.edge_localizer import EdgeLocalizer
from adc_bench.stack.localizer import Localizer
from adc_bench.world.look import draw_look
from adc_bench.world.robot import Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream

LEVELS = ("dark", "dim", "normal", "bright")
STAND_S, WANDER_M, WANDER_MEMORY_M, DELAY_S = 2.0, 0.03, 1.5, 0.07


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[*range(2000000, 2000012)])
    parser.add_argument("--speeds", type=float, nargs="+", default=[1.0, 1.5, 2.0])
    parser.add_argument("--layouts", nargs="+", default=["open", "open", "open", "random_tunnel", "crosswalk_tunnel"])
    parser.add_argument("--laps", type=float, default=2.0)
    parser.add_argument("--thesis", action="store_true")
    options = parser.parse_args()
    renderer = ArenaRenderer(RULES.rig)
    print("| run | localiser | RMSE | 95 % | max | heading | NEES | inside | CPU |\n|" + "---|" * 9)
    runs = zip(options.seeds, itertools.cycle(options.speeds), itertools.cycle(options.layouts), strict=False)
    for seed, speed_mps, layout in runs:
        scenario = arena(seed, layout)
        drive = list(recorded(renderer, scenario, speed_mps, options.laps))
        name = f"{layout}, {scenario.look.light_level}, {speed_mps} m/s"
        for localiser, (poses, covariances, cpu_s) in answers(drive, with_thesis=options.thesis):
            print(f"| {name} | {localiser} | {figures(np.array([t for t, _ in drive]), poses, covariances, cpu_s)} |")


def arena(seed: int, layout: str) -> Scenario:
    """Return an arena of the validation split's looks."""
    return set_up(
        name="localisation",
        seed=seed,
        look=draw_look(load_split("val").looks, stream(seed, "look"), LEVELS[seed % len(LEVELS)]),
        panel_sign="up",
        layout=draw_layout(layout, COURSE, stream(seed, "layout")),
        course=RULES.course,
        arena=RULES.arena,
        robot=RULES.robot,
        rig=RULES.rig,
    )


def recorded(
    renderer: ArenaRenderer, scenario: Scenario, speed_mps: float, laps: float
) -> Iterator[tuple[np.ndarray, Observation]]:
    """Yield the true pose (3,) and what the sensors say, step by step of a drive."""
    simulation, lap = Simulation(scenario, START), COURSE.lap
    renderer.load(scenario)
    rng, s_m, wander_m, coming = np.random.default_rng(scenario.seed), START.x_m, 0.0, Motion()
    while s_m < laps * lap.length_m:
        state, readings, time_s = simulation.state(), simulation.read_sensors(), simulation.time_s
        motion = Motion(v_mps=state.v_mps, omega_radps=state.omega_radps)
        jpeg = renderer.picture("road", simulation.pose3_world_robot(), time_s=time_s, motion=motion)
        rgb = cv2.cvtColor(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
        pose = state.pose_world_robot
        yield (
            np.array([pose.x_m, pose.y_m, pose.yaw_rad]),
            Observation(
                step=simulation.step_index,
                time_s=time_s,
                pictures={"road": Picture(time_s=time_s, rgb=rgb)},
                encoders=readings.encoders,
                imu=readings.imu,
            ),
        )
        share = math.exp(-0.05 * speed_mps / WANDER_MEMORY_M)
        wander_m = share * wander_m + WANDER_M * math.sqrt(1 - share**2) * rng.standard_normal()
        ahead = pose @ Pose2(x_m=DELAY_S * motion.v_mps, y_m=0.0, yaw_rad=DELAY_S * motion.omega_radps)
        along, offset = lap.project([(ahead.x_m, ahead.y_m)], around_s_m=s_m, window_m=2.0)
        s_m += wrap_rad((along[0] - s_m) / lap.length_m * 2 * math.pi) / (2 * math.pi) * lap.length_m
        bend = lap.curvature_pm(s_m + 0.1)[0] + 4 * (wander_m - offset[0])
        bend = float(np.clip(bend + 4 * wrap_rad(lap.pose(s_m).yaw_rad - ahead.yaw_rad), -1.5, 1.5))
        wanted_mps = min(speed_mps, coming.v_mps + 0.075) if time_s >= STAND_S else 0.0
        simulation.advance(coming.v_mps, coming.omega_radps)
        coming = Motion(v_mps=wanted_mps, omega_radps=wanted_mps * bend)


def answers(drive: list, *, with_thesis: bool) -> Iterator[tuple[str, tuple]]:
    """Yield each localiser's name, poses (n, 3), covariances (n, 3, 3) and CPU times (n,)."""
    task = mission(laps=2)
    yield "reference", replayed(EdgeLocalizer(task), drive, [0.0])
    if with_thesis:
        from adc_bench.detector import Detector, shipped_weights

        detector, spent_s = Detector.load(shipped_weights()), [0.0]

        def detect(rgb):
            begun = time.process_time()
            found = detector(rgb)
            spent_s[0] += time.process_time() - begun
            return found

        yield "thesis", replayed(Localizer(mission=task, detect=detect), drive, spent_s)


def replayed(localizer, drive: list, spent_s: list[float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what a localiser answers to a drive; `spent_s` counts the detector's time, which is taken off."""
    state, poses, covariances, cpu_s = localizer.start(), [], [], []
    for _, observation in drive:
        begun = time.process_time() - spent_s[0]
        state = localizer.step(state, observation)
        cpu_s.append(time.process_time() - spent_s[0] - begun)
        poses.append(state.belief.mean)
        covariances.append(state.belief.covariance)
    return np.array(poses), np.array(covariances), np.array(cpu_s)


def figures(truth: np.ndarray, poses: np.ndarray, covariances: np.ndarray, cpu_s: np.ndarray) -> str:
    """Return a row's figures."""
    away_mm = 1e3 * position_errors_m(truth, poses)
    heading_deg = math.degrees(rms(wrap_array_rad(poses[:, 2] - truth[:, 2])))
    values = nees(truth, poses, covariances)
    return (
        f"{rms(away_mm):.1f} | {np.quantile(away_mm, 0.95):.1f} | {away_mm.max():.1f} | {heading_deg:.3f} | "
        f"{values.mean():.2f} | {np.mean(values < COVERED_NEES):.2f} | {1e3 * cpu_s.mean():.2f}"
    )


if __name__ == "__main__":
    main()
