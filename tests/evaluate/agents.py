"""Small submissions, most of them broken in one way each; a `submission.toml` names one as agents:Name."""

import os
import sys
import threading
import time
from pathlib import Path

import numpy as np

from adc_bench.api import Command, Mission, Observation
from adc_bench.geometry import Pose2


class Still:
    def start(self, mission: Mission) -> None:
        self.pose = mission.start_pose

    def step(self, observation: Observation) -> Command:
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=self.pose)


class Straight(Still):
    """Drives straight on at once, with numpy's numbers, and says how sure it is."""

    def step(self, observation: Observation) -> Command:
        covariance = tuple(np.eye(3).ravel())
        return Command(
            v_mps=np.float64(1.5), omega_radps=np.float32(0.0), pose_world_robot=self.pose, covariance=covariance
        )


class Prints(Still):
    def step(self, observation: Observation) -> Command:
        print(f"step {observation.step}")
        sys.stderr.write("to stderr\n")
        return super().step(observation)


class TellsSecrets(Still):
    """Answers with how many variables of its environment name a salt, as the estimate."""

    def step(self, observation: Observation) -> Command:
        count = sum("salt" in f"{name}={value}".lower() for name, value in os.environ.items())
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=Pose2(x_m=float(count), y_m=0.0, yaw_rad=0.0))


class Tells(Still):
    """Answers with what it sees of its world, as the estimate."""

    def step(self, observation: Observation) -> Command:
        picture = observation.pictures["road"]
        red, _, blue = picture.rgb.reshape(-1, 3).mean(axis=0)
        ticks = int(observation.encoders.left_ticks[-1])
        pose = Pose2(x_m=float(red), y_m=float(blue), yaw_rad=observation.time_s)
        return Command(v_mps=float(ticks), omega_radps=float(threading.active_count()), pose_world_robot=pose)


class Counts(Still):
    """Answers with what arrived, as the covariance: when pictures and scan were taken, and what was in them."""

    def step(self, observation: Observation) -> Command:
        pictures, laser, objects = observation.pictures, observation.laser, observation.objects
        told = [pictures[name].time_s if name in pictures else -1.0 for name in ("road", "panel")]
        told += [laser.time_s, laser.ranges_m.sum(), laser.ranges_m.size] if laser else [-1.0, 0.0, 0.0]
        told += [len(objects), sum(seen.pose_robot_object.x_m for seen in objects if seen.category == "crosswalk")]
        covariance = (*told, 0.0, 0.0)
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=self.pose, covariance=covariance)


class RaisesAtSeven(Still):
    def step(self, observation: Observation) -> Command:
        if observation.step == 7:
            raise ValueError("seven is too much")
        return super().step(observation)


class HangsAtThree(Still):
    def step(self, observation: Observation) -> Command:
        if observation.step == 3:
            time.sleep(60)
        return super().step(observation)


class NotFiniteAtTwo(Still):
    def step(self, observation: Observation) -> Command:
        v_mps = float("nan") if observation.step == 2 else 0.0
        return Command(v_mps=v_mps, omega_radps=0.0, pose_world_robot=self.pose)


class NotACommand(Still):
    def step(self, observation: Observation) -> Command:
        return (1.0, 0.0)  # type: ignore[return-value]


class TextInCommand(Still):
    def step(self, observation: Observation) -> Command:
        return Command(v_mps="fast", omega_radps=0.0, pose_world_robot=self.pose)  # type: ignore[arg-type]


class DiesAtFour(Still):
    def step(self, observation: Observation) -> Command:
        if observation.step == 4:
            os._exit(9)
        return super().step(observation)


class ExitsInStart(Still):
    def start(self, mission: Mission) -> None:
        sys.exit(3)


class RaisesInStart(Still):
    def start(self, mission: Mission) -> None:
        raise RuntimeError("no map today")


class HangsInStart(Still):
    def start(self, mission: Mission) -> None:
        time.sleep(60)


class LeavesAChild(Still):
    """Starts a process of its own that would outlive it."""

    def start(self, mission: Mission) -> None:
        super().start(mission)
        import subprocess

        mark = f"import time; time.sleep(600)  # {os.urandom(8).hex()}"
        subprocess.Popen([sys.executable, "-c", mark])
        print(mark)


class NoStep:
    def start(self, mission: Mission) -> None: ...


class NoMethods: ...


def raises_when_made() -> Still:
    raise OSError("no weights")


def dies_when_made() -> Still:
    print("dying")
    os._exit(5)


def hangs_when_made() -> Still:
    time.sleep(60)
    return Still()


def environment() -> Still:
    print(sorted(os.environ), Path.cwd().name, file=sys.stderr)
    return Still()


not_callable = 3


class Slow(Still):
    def step(self, observation: Observation) -> Command:
        time.sleep(0.08)
        return super().step(observation)


class Random(Still):
    """Never says the same twice."""

    def step(self, observation: Observation) -> Command:
        return Command(v_mps=float(os.urandom(1)[0]), omega_radps=0.0, pose_world_robot=self.pose)
