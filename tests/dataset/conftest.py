import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from adc_bench.dataset import load_split
from adc_bench.generate import render_split


@pytest.fixture(scope="session")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of two shards, the second one short: 70 frames, all light levels, a tunnel."""
    root = tmp_path_factory.mktemp("rendered") / "val"
    render_split(load_split("val"), root, count=70, frames_per_shard=64)
    return root


@pytest.fixture
def folder(rendered: Path, tmp_path: Path) -> Path:
    """A copy of it, to be damaged."""
    return Path(shutil.copytree(rendered, tmp_path / "val"))


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 128 KiB: room for two shards of test_faults.py."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=128k", "tmpfs", str(folder)], capture_output=True, text=True
    )
    if mounted.returncode:
        pytest.skip(f"cannot mount a small file system: {mounted.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)
