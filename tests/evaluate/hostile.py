"""Submissions that harm, break rules or break down, in one way each; a `submission.toml` names one as hostile:Name.

`target.txt` beside this file names a file outside of the sandbox.
"""

import contextlib
import ctypes
import os
import socket
import struct
import sys
import time
from pathlib import Path

import numpy as np

from adc_bench.api import Command, Mission, Observation
from adc_bench.geometry import Pose2

AT = 2  # the step at which it happens
MEGABYTE = b"\0" * 2**20


class Hostile:
    """Stands still until the step at which `strike` is called."""

    def start(self, mission: Mission) -> None:
        self.pose = mission.start_pose

    def step(self, observation: Observation) -> Command:
        told = self.strike() if observation.step == AT else None
        return self.stand() if told is None else told

    def stand(self, v_mps: float = 0.0, x_m: float = 0.0) -> Command:
        return Command(v_mps=v_mps, omega_radps=0.0, pose_world_robot=Pose2(x_m=x_m, y_m=0.0, yaw_rad=0.0))

    def strike(self) -> Command | None:
        raise NotImplementedError


class Raises(Hostile):
    def strike(self) -> None:
        raise ValueError("no way on")


class SaysNan(Hostile):
    def strike(self) -> Command:
        return self.stand(v_mps=float("nan"))


class SaysInf(Hostile):
    def strike(self) -> Command:
        return self.stand(x_m=float("inf"))


class SaysHuge(Hostile):
    def strike(self) -> Command:
        return self.stand(x_m=1e300)


class WrongShape(Hostile):
    def strike(self) -> Command:
        pose = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=pose, covariance=np.eye(3))  # type: ignore[arg-type]


class Sleeps(Hostile):
    def strike(self) -> None:
        time.sleep(600)


class BusyLoop(Hostile):
    def strike(self) -> None:
        while True:
            pass


class IsAlwaysSlow(Hostile):
    def step(self, observation: Observation) -> Command:
        time.sleep(0.4)
        return self.stand()


class Exits(Hostile):
    def strike(self) -> None:
        sys.exit(3)


class Segfaults(Hostile):
    def strike(self) -> None:
        ctypes.string_at(0)


class ForkBomb(Hostile):
    def strike(self) -> None:
        while True:
            if os.fork() == 0:
                time.sleep(600)


class EatsMemory(Hostile):
    def strike(self) -> None:
        self.eaten = [np.ones(2**25, dtype=np.uint8) for _ in range(10_000)]


class EatsMemoryInMany(Hostile):
    """Each process stays within its own limit."""

    def strike(self) -> None:
        for _ in range(8):
            if os.fork() == 0:
                self.eaten = np.ones(2**26, dtype=np.uint8)
                time.sleep(600)
        time.sleep(600)


class FillsTmp(Hostile):
    def strike(self) -> None:
        for k in range(10_000):
            Path(os.environ["TMPDIR"], f"{k}").write_bytes(MEGABYTE)


class FillsSharedMemory(Hostile):
    def strike(self) -> None:
        for k in range(10_000):
            Path("/dev/shm", f"{k}").write_bytes(MEGABYTE)


class PrintsMuch(Hostile):
    def strike(self) -> None:
        for _ in range(2**10):
            os.write(1, MEGABYTE)


class ReadsOutside(Hostile):
    def strike(self) -> None:
        print(Path(Path("target.txt").read_text()).read_text())


class ReadsOtherProcesses(Hostile):
    """Tells of every process that it sees and of every environment that it can read."""

    def strike(self) -> None:
        for folder in sorted(Path("/proc").glob("[0-9]*")):
            print((folder / "cmdline").read_bytes().replace(b"\0", b" ")[:60])
            try:
                print((folder / "environ").read_bytes())
            except OSError as error:
                print(error)


class KillsAll(Hostile):
    """Kills whatever it may, which is itself at least."""

    def strike(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(-1, 9)
        os.kill(os.getpid(), 9)


class OpensSocket(Hostile):
    def strike(self) -> None:
        socket.create_connection(("192.0.2.1", 80), timeout=5.0)


class WritesOutside(Hostile):
    def strike(self) -> None:
        Path(Path("target.txt").read_text()).write_text("mine now")


class WritesSystem(Hostile):
    def strike(self) -> None:
        Path("/usr/bin/mine").write_text("mine now")


class ChangesItself(Hostile):
    def strike(self) -> None:
        Path(__file__).write_text("other = True")


class BecomesRoot(Hostile):
    def strike(self) -> None:
        print(os.getuid(), os.geteuid())
        os.setuid(0)


def connection() -> socket.socket:
    """Return the connection to the episode loop, found among the open files."""
    for path in Path("/proc/self/fd").iterdir():
        try:
            end = socket.socket(fileno=os.dup(int(path.name)))
            end.getpeername()
        except OSError:
            continue
        if end.family == socket.AF_UNIX:
            return end
    raise FileNotFoundError("no connection")


class SendsGarbage(Hostile):
    def strike(self) -> None:
        connection().sendall(struct.pack("!I", 6) + b"\xc1\xff\xfe\x00ab")
        time.sleep(600)


class SendsDeepNesting(Hostile):
    def strike(self) -> None:
        connection().sendall(struct.pack("!I", 60_000) + b"\x91" * 60_000)
        time.sleep(600)


class SendsTooMuch(Hostile):
    def strike(self) -> None:
        connection().sendall(struct.pack("!I", 2**31))
        time.sleep(600)


class SendsHalf(Hostile):
    def strike(self) -> None:
        connection().sendall(struct.pack("!I", 100) + b"\x80")
        time.sleep(600)


class AnswersTwice(Hostile):
    """Says the same once more, by hand."""

    def strike(self) -> None:
        from adc_bench.evaluate.protocol import command_message
        from adc_bench.evaluate.wire import Channel

        Channel(connection()).send(command_message(AT, self.stand()))


class HangsUp(Hostile):
    def strike(self) -> None:
        connection().shutdown(socket.SHUT_RDWR)
        time.sleep(600)
