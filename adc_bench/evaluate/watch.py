"""A thread beside the episode loop that keeps what a submission prints, and ends it when it holds too much memory."""

import contextlib
import os
import selectors
import subprocess
import threading
from pathlib import Path

from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.limits import Limits

PERIOD_S = 0.1
PIPE_BYTES = 64 * 2**10
PARTS = 256  # then it is time to look at the memory again


class Watch:
    """Reads a process' output, a pipe, to its end; `verdict` is set before the process is killed."""

    def __init__(self, process: subprocess.Popen[bytes], limits: Limits) -> None:
        assert process.stdout is not None
        self._process, self._limits, self._output = process, limits, process.stdout
        self._kept, self._dropped_bytes = bytearray(), 0
        self._stopped = threading.Event()
        self.verdict: Ending | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Return when the thread has read what was left; the process has been killed before."""
        self._stopped.set()
        self._thread.join()
        self._output.close()

    @property
    def printed(self) -> bytes:
        """What the process has printed, with a last line on what was dropped."""
        dropped = f"\n({self._dropped_bytes} bytes more were not kept)\n" if self._dropped_bytes else ""
        return bytes(self._kept) + dropped.encode()

    def _run(self) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(self._output, selectors.EVENT_READ)
            os.set_blocking(self._output.fileno(), False)
            while self._read_what_is_there(selector) and not self._stopped.is_set():
                self._check_memory()
            self._read_what_is_there(selector)

    def _read_what_is_there(self, selector: selectors.BaseSelector) -> bool:
        """Read for one period; return whether more may come."""
        if not selector.select(0.0 if self._stopped.is_set() else PERIOD_S):
            return True
        for _ in range(PARTS):
            try:
                part = os.read(self._output.fileno(), PIPE_BYTES)
            except BlockingIOError:
                return True
            if not part:
                return False
            room = self._limits.printed_bytes - len(self._kept)
            self._kept += part[:room]
            self._dropped_bytes += len(part[room:])
        return True

    def _check_memory(self) -> None:
        held_bytes = resident_bytes(self._process.pid)
        if held_bytes > self._limits.memory_bytes and self.verdict is None:
            allowed = f"{self._limits.memory_bytes / 2**20:.0f} MiB"
            self.verdict = Ending(reason=Reason.MEMORY, detail=f"its processes held more than {allowed}")
            self._process.kill()


def resident_bytes(pid: int) -> int:
    """Return the memory that a process and all that descend from it hold, added up; mapped files do not count."""
    total, waiting = 0, [pid]
    while waiting:
        folder = Path("/proc", str(waiting.pop()))
        with contextlib.suppress(OSError):  # it has ended meanwhile
            for line in (folder / "status").read_text().splitlines():
                if line.startswith(("RssAnon:", "RssShmem:")):
                    total += int(line.split()[1]) * 2**10
            for task in (folder / "task").iterdir():
                waiting += map(int, (task / "children").read_text().split())
    return total
