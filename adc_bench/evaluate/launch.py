"""A submission's process: its folder of work, its start in a sandbox or without one, its end."""

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

import msgspec

from adc_bench.evaluate.agent_side import Isolation, Load
from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.sandbox import LINK, PACKAGE, TMP, Room, in_sandbox, limited, sandbox_fault
from adc_bench.evaluate.shelf import WrittenShelf
from adc_bench.evaluate.submission_files import stage
from adc_bench.evaluate.watch import Watch
from adc_bench.world.sensors import SensorRig

PYTHON = (sys.executable, "-P", "-X", "faulthandler", "-m", "adc_bench.evaluate.child")
SYSTEM_PATH = "/usr/local/bin:/usr/bin:/bin"
# All that a submission's process gets of an environment: one thread for every library that would choose a number.
ENVIRONMENT = {
    "LANG": "C.UTF-8",
    "LOGNAME": "agent",
    "USER": "agent",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "PYTHONHASHSEED": "0",
    "PYTHONUNBUFFERED": "1",
    "PYTHONDONTWRITEBYTECODE": "1",
    "PYTHONPATH": str(PACKAGE.parent),
}
END_S = 5.0  # for a process whose connection has closed to end by itself


class Launched:
    """A submission's process with what it shares with the loop: `listener` (a Unix socket) and `shelf` (the pictures).

    `isolation` says whether it is in a sandbox, or runs with limits only since this machine has none. Close it always.

    Raises:
        InputError: the submission's files are not those that were loaded.
    """

    def __init__(self, load: Load, rig: SensorRig, limits: Limits) -> None:
        self._load, self._limits = load, limits
        self.isolation: Isolation = "none" if sandbox_fault() else "bubblewrap"
        with contextlib.ExitStack() as undo:
            self._work = Path(tempfile.mkdtemp(prefix="adc-bench-"))
            undo.callback(shutil.rmtree, self._work, ignore_errors=True)
            for name in ("submission", "link", "tmp"):
                (self._work / name).mkdir(mode=0o755)
            if load.folder is not None:
                stage(Path(load.folder), self._work / "submission", load.options, load.sha256)
            self.shelf = WrittenShelf(self._work / "link" / "pictures", rig)
            undo.callback(self.shelf.close)
            self.listener = undo.enter_context(_listening(self._work / "link" / "socket"))
            self._process = self._started()
            self.watch = Watch(self._process, limits)
            undo.callback(self._end)
            self._undo = undo.pop_all()

    def _started(self) -> subprocess.Popen[bytes]:
        load = self._load
        command = load.command or (*PYTHON, msgspec.json.encode(load).decode())
        is_walled = self.isolation == "bubblewrap"
        link, tmp = (LINK, TMP) if is_walled else (self._work / "link", self._work / "tmp")
        environment = {
            **ENVIRONMENT,
            "PATH": f"{Path(sys.executable).parent}:{SYSTEM_PATH}",
            "HOME": str(tmp),
            "TMPDIR": str(tmp),
            "ADC_BENCH_SOCKET": str(link / "socket"),
            "ADC_BENCH_PICTURES": str(link / "pictures"),
        }
        submission = None if load.folder is None else self._work / "submission"
        files = [Path(value) for value in load.options.values() if Path(value).is_file()]
        room = Room(submission=submission, link=self._work / "link", files=files, environment=environment)
        return subprocess.Popen(
            in_sandbox(command, room, self._limits) if is_walled else limited(command, self._limits),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            cwd="/" if is_walled else submission or tmp,
            env={"PATH": SYSTEM_PATH} if is_walled else environment,  # a sandbox shows what it was started with
            start_new_session=True,
        )

    def _end(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self.watch.stop()

    def close(self) -> None:
        """Kill the process with all that it started, and remove its folder."""
        self._undo.close()

    @property
    def has_ended(self) -> bool:
        """Whether the process is gone."""
        return self._process.poll() is not None

    def how_it_ended(self) -> str:
        """Return how the process ended, waiting a little for it to do so."""
        try:
            code = self._process.wait(timeout=END_S)
        except subprocess.TimeoutExpired:
            return "it closed its connection"
        killer = -code if code < 0 else code - 128  # the sandbox tells of a signal as shells do
        try:
            return f"killed by {signal.Signals(killer).name}"
        except ValueError:
            return f"exit status {code}"


def _listening(path: Path) -> socket.socket:
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(str(path))
    path.chmod(0o666)  # the submission's user is another
    listener.listen(1)
    return listener
