"""The nodes of an existing Ray cluster, found by Ray's own configuration (`RAY_ADDRESS`, `ray start`)."""

import logging
import os
import socket
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any

from adc_bench.engine.task import LOG, TRIES, Answer, Done, Numbered, answer, died_too_often
from adc_bench.errors import MachineError

CANCEL_S = 10.0  # for workers to end when the run ends early
KNOCK_S = 5.0
DEATHS = ("WorkerCrashedError", "NodeDiedError", "OutOfMemoryError", "ObjectLostError", "OwnerDiedError")


def run_on_ray(
    function: Callable[[Any], Any], tasks: Numbered, workers: int | None, tell: Callable[[Done[Any]], None]
) -> None:
    """Do the tasks on at most `workers` CPUs of the cluster (all if None); `tell` is told of each as it ends."""
    with _cluster() as ray, _Flight(ray, function) as flight:
        for index, task in tasks:
            while len(flight.tasks) >= (workers or 2 * _cpus(ray)):
                flight.land(tell)
            flight.take_off(index, task)
        while flight.tasks:
            flight.land(tell)


class _Flight:
    """The tasks that Ray has now: never all of them; leaving the context calls back what is still under way."""

    def __init__(self, ray: Any, function: Callable[[Any], Any]) -> None:
        self._ray, self._function = ray, function
        # Deaths are counted and told here, as with local workers, so Ray itself tries nothing again.
        self._remote = ray.remote(num_cpus=1, max_retries=0)(_answer_on_node)
        self._deaths: Counter[int] = Counter()
        self.tasks: dict[Any, tuple[int, Any]] = {}

    def __enter__(self) -> "_Flight":
        return self

    def __exit__(self, *_: object) -> None:
        for reference in self.tasks:
            self._ray.cancel(reference)  # as Ctrl-C in the worker, which cleans up after itself
        if self.tasks:
            self._ray.wait(list(self.tasks), num_returns=len(self.tasks), timeout=CANCEL_S)

    def take_off(self, index: int, task: Any) -> None:
        self.tasks[self._remote.remote(self._function, task)] = index, task

    def land(self, tell: Callable[[Done[Any]], None]) -> None:
        """Wait for a task to end and tell of it; one whose worker or node died takes off again."""
        (ready,), _ = self._ray.wait(list(self.tasks), num_returns=1)
        index, task = self.tasks.pop(ready)
        try:
            said: Answer = self._ray.get(ready)
        except self._ray.exceptions.RayError as error:
            self._try_again(index, task, error)
        else:
            tell(said.done(index))

    def _try_again(self, index: int, task: Any, error: Exception) -> None:
        kind, how = type(error).__name__, str(error).strip().splitlines()
        if kind not in DEATHS:
            raise MachineError(
                where="a node of the Ray cluster",
                found=f"{kind}: {how[-1]}",
                wanted="every node with the same Python, Ray and adc-bench as this one",
                todo="install the same versions on every node, then run again",
            ) from error
        self._deaths[index] += 1
        if self._deaths[index] == TRIES:
            raise died_too_often(index, f"({kind}: {how[0]})")
        LOG.warning("a worker died (%s); its task (%d) is tried again", kind, index)
        self.take_off(index, task)


def _answer_on_node(function: Callable[[Any], Any], task: Any) -> Answer:
    import ray

    node = f"{socket.gethostname()} ({ray.get_runtime_context().get_node_id()[:6]})"
    return answer(function, task, node)


def _cpus(ray: Any) -> int:
    """Return how many CPUs the cluster has now: nodes may come and go."""
    return max(1, int(ray.cluster_resources().get("CPU", 1)))


@contextmanager
def _cluster() -> Iterator[Any]:
    """Yield the module `ray`, connected to the cluster; a connection made here is closed here."""
    try:
        import ray
    except ImportError:
        raise MachineError(
            where="--engine ray",
            found="Ray is not installed",
            wanted="the package ray",
            todo='pip install "adc-bench[ray]"',
        ) from None
    if ray.is_initialized():
        yield ray
        return
    try:
        _knock(_address())
        ray.init(address="auto", log_to_driver=False, logging_level=logging.ERROR)
    except (OSError, RuntimeError, ValueError) as error:
        raise MachineError(
            where="--engine ray",
            found=f"no cluster to connect to: {str(error).strip().splitlines()[0]}",
            wanted="a running Ray cluster, at RAY_ADDRESS or started on this machine",
            todo="ray start --head on one machine, ray start --address=HEAD:6379 on the others; then run again",
        ) from None
    with redirect_stdout(sys.stderr):  # Ray tells of nodes that died on stdout, where only our report belongs
        try:
            yield ray
        finally:
            ray.shutdown()


def _address() -> str:
    """Return where Ray will look for its cluster, or nothing: RAY_ADDRESS, or the last one started on this machine."""
    scratch = os.environ.get("RAY_TMPDIR") or os.environ.get("TMPDIR") or "/tmp"
    started = Path(scratch, "ray", "ray_current_cluster")
    return os.environ.get("RAY_ADDRESS") or (started.read_text().strip() if started.is_file() else "")


def _knock(address: str) -> None:
    """Raise OSError if nobody listens at an address HOST:PORT: Ray itself would wait for minutes."""
    host, _, port = address.rpartition("/")[2].rpartition(":")
    if host and port.isdigit():
        try:
            socket.create_connection((host.strip("[]"), int(port)), timeout=KNOCK_S).close()
        except OSError as error:
            raise OSError(f"nobody answers at {address} ({error.strerror or error})") from None
