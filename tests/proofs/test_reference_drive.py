"""The reference driver from pixels against its targets, on arenas of no suite."""

from pathlib import Path

import msgspec
import pytest

from adc_bench.evaluate.run import evaluate_submission
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import load_suite


@pytest.mark.slow
def test_two_laps_at_the_limit_from_pixels(tmp_path: Path) -> None:
    suite = msgspec.structs.replace(load_suite("d1"), seeds=(501, 502, 503, 504))  # each of the four light levels
    result = evaluate_submission(load_submission("reference", {}), suite, tmp_path, in_process=True)
    for episode in result.episodes:
        assert episode.status == "success"
        assert episode.run_time_s is not None and episode.run_time_s < 41.0
        assert episode.driving.line_touches == 0
        assert episode.driving.cross_track_max_m is not None and episode.driving.cross_track_max_m < 0.05
        assert episode.localization is not None and episode.localization.position_max_m < 0.15
        assert episode.localization.position_rmse_m < 0.02
