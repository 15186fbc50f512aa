"""What a node that makes shards must be: the plan's software and kind of processor, and the folder in sight.

Other versions, or a processor for which the driver compiles other code, give other bytes.
"""

import socket
from functools import lru_cache
from importlib.metadata import version

from adc_bench import __version__
from adc_bench.dataset.layout import MANIFEST
from adc_bench.dataset.store import Store
from adc_bench.errors import MachineError

PACKAGES = ("sapien", "numpy", "opencv-python-headless", "h5py")


def software(device_name: str) -> dict[str, str]:
    """Return all that decides on the bytes: versions, and the driver with the vector width that it compiles for."""
    return {**_versions(), "renderer": device_name}


def check_software(wanted: dict[str, str], device_name: str) -> None:
    """Raise MachineError if this machine would give other bytes than the one that made the plan."""
    here = software(device_name)
    for name, value in wanted.items():
        if here.get(name) != value:
            raise MachineError(
                where=f"node {socket.gethostname()}",
                found=f"{name} {here.get(name)}",
                wanted=f"{name} {value}, as where the run was started: others give other bytes",
                todo="install the same versions on every node, and keep to nodes whose processors are of one kind",
            )


def check_sight(store: Store) -> None:
    """Raise MachineError if the dataset that was begun is not seen from here."""
    if not store.exists(MANIFEST):
        raise MachineError(
            where=f"node {socket.gethostname()}",
            found=f"no {store.path(MANIFEST)}",
            wanted="the folder that the run was started on",
            todo="write to a folder that all nodes share, or to an address as s3://bucket/name",
        )


@lru_cache(maxsize=1)
def _versions() -> dict[str, str]:
    return {"adc_bench": __version__, **{name: version(name) for name in PACKAGES}}
