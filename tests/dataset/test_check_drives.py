"""`dataset check`, `stats` and `preview` of drives: a sound one is silent, each fault in its log is named."""

import shutil
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from amended import amend

from adc_bench.dataset import FrameDataset, load_split
from adc_bench.dataset.check import Looked, find_problems
from adc_bench.dataset.drives import DriveDataset
from adc_bench.dataset.preview import page_of
from adc_bench.dataset.stats import statistics_of
from adc_bench.generate import render_split


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("driven") / "one"
    split = load_split("val")
    recipe = msgspec.structs.replace(
        split.drives, duration_s=(4.0, 4.0), missions={"speed": 1.0}, behaviours={"clean": 1.0}
    )
    render_split(msgspec.structs.replace(split, drives=recipe), root, kind="drives", count=1, size_px=(96, 72))
    return root


@pytest.fixture
def copied(driven: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(driven, tmp_path / "one"))


def test_a_sound_drive_has_no_problems(driven: Path) -> None:
    looked = Looked()
    assert list(find_problems(FrameDataset(driven), looked=looked)) == []
    assert looked.frames == len(FrameDataset(driven)) > 90


def put(index: object, value: object) -> Callable[[np.ndarray], None]:
    return lambda values: values.__setitem__(index, value)


def shift(index: object, by: float) -> Callable[[np.ndarray], None]:
    return lambda values: values.__setitem__(index, values[index] + by)


def stretch(share: float) -> Callable[[np.ndarray], None]:
    return lambda values: values.__setitem__(..., (values * share).astype(values.dtype))


FAULTS = [
    ("truth/time_s", shift(5, 0.01), "truth: its time stamps are not evenly spaced"),
    ("truth/pose_world_robot", put((4, 0), np.nan), "truth: a pose is not finite"),
    ("truth/pose_world_robot", shift((4, 3), 0.1), "truth: a pose has no unit quaternion"),
    ("truth/pose_world_robot", shift((..., 0), 0.1), "its robot is 0.1"),
    ("encoders/time_s", put(3, 0.0), "encoders: time stamps do not increase"),
    ("imu/time_s", shift(slice(100, None), 0.01), "imu: samples 0.0100 to 0.0200 s apart, not 0.0100 s"),
    ("laser/arrival_time_s", shift(..., 0.05), "laser: samples do not arrive 0.0 s after they were taken"),
    ("pictures/time_s", shift(0, -0.02), "pictures: camera"),
    ("encoders/left_ticks", stretch(1.2), "rad rolled on a turn of"),
    ("encoders/right_ticks", stretch(0.8), "m rolled on a way of"),
    ("imu/yaw_rate_radps", shift(..., 0.1), "imu: its gyro turns by"),
]


@pytest.mark.parametrize(("name", "change", "sentence"), FAULTS)
def test_a_fault_in_the_log_is_named(
    copied: Path, name: str, change: Callable[[np.ndarray], None], sentence: str
) -> None:
    amend(copied, name, change)
    told = list(find_problems(FrameDataset(copied), sample=0))
    assert told and all(problem.startswith("shard-00000.h5") for problem in told)
    assert any(sentence in problem for problem in told), told[:5]


def test_stats_and_preview_of_drives(driven: Path) -> None:
    charts = {chart.title: chart for chart in statistics_of(FrameDataset(driven)).charts}
    log = DriveDataset(driven).drive(0)
    assert charts["Missions"].rows == ("speed",) and charts["Missions"].totals == (1,)
    assert sum(charts["Speeds"].totals) == len(log.truth["time_s"])
    assert page_of(FrameDataset(driven), 5).count(b"<figure ") == 5
