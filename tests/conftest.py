"""What holds for every room's tests."""

import os
import shutil
import signal
import tempfile
from collections.abc import Iterator
from typing import Any

import pytest

# As the command has it (cli/main.py), before anything imports numpy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# A shell's background job starts with Ctrl-C ignored, and every process inherits that: the tests that press it need it.
signal.signal(signal.SIGINT, signal.default_int_handler)

SMALL_NODE = {"num_cpus": 1, "object_store_memory": 80 * 2**20}


@pytest.fixture(scope="session")
def ray_cluster() -> Iterator[Any]:
    """A Ray cluster of two nodes on this machine; processes started meanwhile find it by RAY_ADDRESS."""
    scratch = tempfile.mkdtemp(prefix="ray")  # short, for names of sockets; and away from any cluster that is in use
    settings = {
        "RAY_TMPDIR": scratch,
        "RAY_USAGE_STATS_ENABLED": "0",
        "RAY_DISABLE_DOCKER_CPU_WARNING": "1",
        "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",
    }
    with pytest.MonkeyPatch.context() as patch:
        for name, value in settings.items():
            patch.setenv(name, value)
        from ray.cluster_utils import Cluster

        cluster = Cluster(initialize_head=True, head_node_args={"include_dashboard": False, **SMALL_NODE})
        cluster.add_node(**SMALL_NODE)
        patch.setenv("RAY_ADDRESS", cluster.address)
        yield cluster
        cluster.shutdown()
    shutil.rmtree(scratch)
