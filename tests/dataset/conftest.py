import shutil
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
