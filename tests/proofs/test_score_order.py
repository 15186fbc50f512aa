"""The score in order: the oracle first, who stands still last, and who drives better above who drives worse."""

from pathlib import Path

import pytest

from adc_bench.evaluate.results import Result
from adc_bench.evaluate.run import evaluate_submission
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import load_suite

DRIVERS = ("oracle", "reference", "thesis", "lane-follower", "stand-still")
SAME_POINTS = 1.0  # a second of driving


@pytest.mark.slow
def test_the_oracle_is_first_and_who_stands_still_is_last(tmp_path: Path) -> None:
    """On a lap of pure speed. A perfect pose buys the reference little: its own is right to millimetres."""
    suite = load_suite("dev")
    results: dict[str, Result] = {}
    for name in DRIVERS:
        results[name] = evaluate_submission(load_submission(name, {}), suite, tmp_path / name, in_process=True)
    points = {name: result.summary["points"].mean for name, result in results.items()}
    assert max(points.values()) < points["oracle"] + SAME_POINTS
    assert points["stand-still"] == 0.0
    assert all(points[name] > 50.0 for name in DRIVERS if name != "stand-still")
    assert points["reference"] > max(points["thesis"], points["lane-follower"])
    assert results["stand-still"].summary["completion"].mean == 0.0
