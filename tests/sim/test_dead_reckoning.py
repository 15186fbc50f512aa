"""What encoders alone are worth: the figure that benchmark.md states, on fewer laps than `benchmarks/odometry.py`."""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest


@pytest.fixture(scope="module")
def odometry() -> ModuleType:
    path = Path(__file__).parents[2] / "benchmarks" / "odometry.py"
    spec = importlib.util.spec_from_file_location("odometry", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_lap_by_encoders_alone_goes_astray_by_the_stated_distance(odometry: ModuleType) -> None:
    """Worst error over a lap at 1 m/s: median 0.2-0.5 m over many robots; here of six."""
    worst_m = []
    for seed in range(6):
        truth, reckoned, _ = odometry.lap(seed, 1.0)
        assert 38 < truth[-1, 0] < 44
        worst_m.append(odometry.worst_error(truth, reckoned)[0])
    assert 0.2 < np.median(worst_m) < 0.5
    assert max(worst_m) < 2.0, "a left-right difference of 1 % would give 6 m"
