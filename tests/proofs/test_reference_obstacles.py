"""The reference driver past boxes, through tunnels and road-works, from pixels, a lap an arena of no suite."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from adc_bench.evaluate.run import evaluate_submission
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import load_suite

ARENAS = 20
SUITES = Path(__file__).parents[2] / "benchmarks/suites"


@pytest.mark.slow
@pytest.mark.parametrize(("name", "first", "share"), [("boxes", 8501, 0.98), ("works", 8601, 0.95)])
def test_every_order_is_obeyed_past_what_stands_on_the_road(
    name: str, first: int, share: float, tmp_path: Path
) -> None:
    suite = msgspec.structs.replace(load_suite(str(SUITES / f"{name}.toml")), seeds=tuple(range(first, first + ARENAS)))
    result = evaluate_submission(load_submission("reference", {}), suite, tmp_path, in_process=True)
    perfect = [run.reason == "finished" and run.driving_score == 100.0 for run in result.episodes]
    assert np.mean(perfect) >= share, [run.seed for run, good in zip(result.episodes, perfect, strict=True) if not good]
    for run in result.episodes:
        assert run.localization is not None and run.localization.position_max_m < 0.15
        assert run.localization.position_rmse_m < 0.03
        assert run.localization.heading_rmse_rad < np.radians(0.8)
