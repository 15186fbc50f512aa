"""The reference driver before the panels, from pixels, on arenas of no suite."""

from pathlib import Path

import msgspec
import pytest

from adc_bench.evaluate.run import evaluate_submission
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import load_suite


@pytest.mark.slow
@pytest.mark.parametrize("name", ["d2", "p1"])
def test_every_order_is_obeyed_without_a_fault(name: str, tmp_path: Path) -> None:
    suite = msgspec.structs.replace(load_suite(name), seeds=(511, 512, 513, 514, 515))  # each trial of d2
    result = evaluate_submission(load_submission("reference", {}), suite, tmp_path, in_process=True)
    for episode in result.episodes:
        assert (episode.status, episode.reason) == ("success", "finished")
        assert episode.driving_score == 100.0
        assert episode.localization is not None and episode.localization.position_max_m < 0.15
