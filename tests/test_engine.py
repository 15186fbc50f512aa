import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from adc_bench.engine import run_tasks
from adc_bench.errors import MachineError


def _slow_square(number: int) -> int:
    time.sleep(0.02 * (number % 3))
    return number * number


def _fail(number: int) -> int:
    if number == 2:
        raise MachineError(where="here", found="nothing", wanted="a driver", todo="install one")
    return number


def _divide(number: int) -> float:
    return 1 / number


def _die(number: int) -> int:
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


@pytest.mark.parametrize("workers", [1, 2])
def test_results_keep_the_order_of_the_tasks(workers: int) -> None:
    told: dict[int, int] = {}
    results = run_tasks(_slow_square, range(9), workers=workers, done=told.__setitem__)
    assert results == [n * n for n in range(9)]
    assert told == {n: n * n for n in range(9)}


def test_no_tasks_no_results() -> None:
    assert run_tasks(_slow_square, [], workers=2) == []


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_for_the_user_arrives_whole(workers: int) -> None:
    with pytest.raises(MachineError) as caught:
        run_tasks(_fail, range(4), workers=workers)
    assert (caught.value.where, caught.value.todo) == ("here", "install one")


def test_a_fault_in_a_worker_arrives_with_its_traceback() -> None:
    with pytest.raises(RuntimeError, match=r"_divide(.|\n)*ZeroDivisionError"):
        run_tasks(_divide, [1, 0], workers=2)


def test_a_killed_worker_is_told() -> None:
    with pytest.raises(RuntimeError, match="exit code -9"):
        run_tasks(_die, range(3), workers=2)


SLEEPERS = "import time\nfrom adc_bench.engine import run_tasks\nrun_tasks(time.sleep, [60, 60], workers=2)"


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_workers_end_with_their_parent(how: signal.Signals) -> None:
    parent = subprocess.Popen([sys.executable, "-c", SLEEPERS], stderr=subprocess.DEVNULL)
    while len(workers := _spawned(parent.pid)) < 2:
        assert parent.poll() is None
        time.sleep(0.05)
    parent.send_signal(how)
    assert parent.wait(10) != 0
    deadline_s = time.monotonic() + 5
    while any(_alive(pid) for pid in workers):
        assert time.monotonic() < deadline_s
        time.sleep(0.02)


def _spawned(parent: int) -> list[int]:
    children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    return [int(c) for c in children if b"spawn_main" in Path(f"/proc/{c}/cmdline").read_bytes()]


def _alive(pid: int) -> bool:
    stat = Path(f"/proc/{pid}/stat")
    return stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z"
