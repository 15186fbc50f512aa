"""filterpy's extended Kalman filter says the same as ours, step by step, on the same inputs.

`sh scripts/outside.sh` installs it into an environment of its own in `.peers/`.
"""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from adc_bench.stack.ekf import see_point
from adc_bench.stack.pose_filter import (
    SIZE,
    Estimate,
    MotionNoise,
    Residuals,
    StartSpread,
    Travel,
    correct,
    motion_noise,
    predict,
    start_estimate,
)
from adc_bench.world.course import Course

ROOT = Path(__file__).parents[2]
NOISE, STEPS, R_M2 = MotionNoise(), 400, 0.03**2

pytestmark = pytest.mark.slow


def test_filterpy_agrees_over_a_lap(tmp_path: Path) -> None:
    python = ROOT / ".peers" / "filterpy" / "bin" / "python"
    if not python.exists():
        pytest.skip("no .peers/filterpy: sh scripts/outside.sh makes it")
    rng, lap = np.random.default_rng(7), Course().lap
    estimate = start_estimate(lap.pose(0.0), StartSpread())
    start, ways, noises, landmarks, sightings, ours = estimate, [], [], [], [], []
    for _ in range(STEPS):
        way = Travel(
            duration_s=np.full(5, 0.01),
            forward_m=rng.normal(0.02, 0.002, 5),
            turn_rad=rng.normal(0.005, 0.005, 5),
            slip_m=0.0,
        )
        noises.append(motion_noise(estimate.mean, way, NOISE))
        estimate = predict(estimate, way, NOISE)
        landmark = rng.uniform(-6, 6, 2)
        expected, jacobian = see_point(estimate.mean[:3], landmark)
        sighting = expected + rng.normal(0, 0.03, 2)
        rows = np.hstack([jacobian, np.zeros((2, SIZE - 3))])
        residuals = Residuals(values=sighting - expected, jacobian=rows, variances=np.full(2, R_M2))
        estimate = correct(estimate, residuals)
        ways.append(np.column_stack([way.duration_s, way.forward_m, way.turn_rad]))
        landmarks.append(landmark)
        sightings.append(sighting)
        ours.append(estimate)
    theirs = filterpy_on(python, tmp_path, start, ways=ways, Q=noises, landmarks=landmarks, seen=sightings)
    for estimate, mean, covariance in zip(ours, theirs["means"], theirs["covariances"], strict=True):
        difference = estimate.mean - mean
        difference[2] = np.remainder(difference[2] + np.pi, 2 * np.pi) - np.pi
        assert np.abs(difference).max() < 1e-9
        assert np.abs(estimate.covariance - covariance).max() < 1e-9


def filterpy_on(python: Path, folder: Path, start: Estimate, **steps: list[np.ndarray]) -> dict[str, np.ndarray]:
    """Return filterpy's means and covariances after each step."""
    given, found = folder / "steps.npz", folder / "found.npz"
    np.savez(given, mean=start.mean, covariance=start.covariance, R=R_M2 * np.eye(2), **steps)
    script = Path(__file__).parent / "outside" / "filterpy_steps.py"
    words = [str(python), "-W", "ignore", str(script), str(given), str(found)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return dict(np.load(found))
