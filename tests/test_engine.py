import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from adc_bench.engine import TRIES, Done, run_tasks
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


def _die_at_first(task: tuple[Path, int]) -> int:
    """Die in the first tries of a task, as many as it says."""
    folder, deaths = task
    seen = len(list(folder.iterdir()))
    if seen < deaths:
        (folder / str(seen)).touch()
        os._exit(7)
    return seen


def _results(function: Any, tasks: Any, **options: Any) -> dict[int, Any]:
    told: dict[int, Any] = {}

    def tell(done: Done[Any]) -> None:
        assert done.index not in told and done.elapsed_s >= 0
        told[done.index] = done.result

    run_tasks(function, tasks, done=tell, **options)
    return told


@pytest.mark.parametrize("workers", [1, 2, None])
def test_every_task_is_done_once(workers: int | None) -> None:
    assert _results(_slow_square, range(9), workers=workers) == {n: n * n for n in range(9)}


@pytest.mark.parametrize("workers", [1, 2])
def test_no_tasks_no_results(workers: int) -> None:
    assert _results(_slow_square, [], workers=workers) == {}


@pytest.mark.parametrize("workers", [1, 2])
def test_tasks_are_taken_as_they_are_needed(workers: int) -> None:
    taken, told = 0, 0

    def tasks() -> Iterator[int]:
        nonlocal taken
        for number in range(8):
            taken += 1
            assert taken - told <= workers + 1
            yield number

    def tell(_: Done[int]) -> None:
        nonlocal told
        told += 1

    run_tasks(_slow_square, tasks(), workers=workers, done=tell)
    assert told == 8


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_for_the_user_arrives_whole(workers: int) -> None:
    with pytest.raises(MachineError) as caught:
        _results(_fail, range(4), workers=workers)
    assert (caught.value.where, caught.value.todo) == ("here", "install one")


def test_a_fault_in_a_worker_arrives_with_its_traceback() -> None:
    with pytest.raises(RuntimeError, match=r"_divide(.|\n)*ZeroDivisionError"):
        _results(_divide, [1, 0], workers=2)


def test_a_dead_worker_is_replaced_and_its_task_tried_again(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    tasks = [(tmp_path / "a", TRIES - 1), (tmp_path / "b", 0)]
    assert _results(_die_at_first, tasks, workers=2) == {0: TRIES - 1, 1: 0}
    warning = "a worker died with exit code 7; its task (0) is tried again"
    assert [record.getMessage() for record in caplog.records] == [warning] * (TRIES - 1)


def test_a_task_that_no_worker_survives_is_told() -> None:
    with pytest.raises(MachineError) as caught:
        _results(_die, range(3), workers=2)
    assert caught.value.where == "task 1"
    assert caught.value.found == "its worker died 3 times, the last time of SIGKILL"


SLEEPERS = "import time\nfrom adc_bench.engine import run_tasks\nrun_tasks(time.sleep, [60, 60], workers=2, done=print)"


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


def _ray_job(what: str, scratch: Path) -> tuple[dict[str, Any], str]:
    command = [sys.executable, str(Path(__file__).parent / "ray_job.py"), what, str(scratch)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


@pytest.mark.usefixtures("ray_cluster")
def test_a_cluster_does_every_task_on_all_its_nodes(tmp_path: Path) -> None:
    told, _ = _ray_job("squares", tmp_path)
    assert told["results"] == [n * n for n in range(12)]
    assert len(told["nodes"]) == 2
    assert told["ahead"] <= 5  # twice the CPUs: what is in flight


@pytest.mark.usefixtures("ray_cluster")
def test_an_error_on_a_node_arrives_whole(tmp_path: Path) -> None:
    told, _ = _ray_job("error", tmp_path)
    assert told == {"kind": "MachineError", "found": "nothing", "todo": "install 7"}


@pytest.mark.usefixtures("ray_cluster")
def test_deaths_on_a_node_are_forgiven_but_not_for_ever(tmp_path: Path) -> None:
    told, warned = _ray_job("deaths", tmp_path)
    assert told["results"] == [f"{tmp_path}/mark"]
    assert "a worker died (WorkerCrashedError); its task (0) is tried again" in warned
    told, _ = _ray_job("poison", tmp_path)
    assert told["kind"] == "MachineError" and "its worker died 3 times" in told["found"]


def test_no_cluster_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RAY_ADDRESS", "127.0.0.1:9")  # the port that discards: nobody answers
    told, _ = _ray_job("error", tmp_path)
    assert told["found"] == "no cluster to connect to: nobody answers at 127.0.0.1:9 (Connection refused)"
    assert told["todo"].startswith("ray start --head")


def test_ray_that_is_not_installed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(MachineError) as caught:
        _results(_slow_square, [1], engine="ray")
    assert caught.value.todo == 'pip install "adc-bench[ray]"'
