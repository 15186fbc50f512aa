"""What the detector is trained on is what the driver sees: the same bytes become the same pixels."""

import numpy as np
import pytest

from adc_bench.api import EncoderSamples, ImuSamples
from adc_bench.dataset import FrameDataset, load_split
from adc_bench.evaluate.sensed import Sensed, observation_of
from adc_bench.generate import render_split
from adc_bench.world.picture import decode_picture

NO_TICKS = EncoderSamples(time_s=np.zeros(0), left_ticks=np.zeros(0, np.int64), right_ticks=np.zeros(0, np.int64))
NO_TURNS = ImuSamples(time_s=np.zeros(0), yaw_rate_radps=np.zeros(0), acceleration_x_mps2=np.zeros(0))


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> FrameDataset:
    root = tmp_path_factory.mktemp("pictures") / "val"
    render_split(load_split("val"), root, count=4, size_px=(160, 120))
    return FrameDataset(root)


def test_a_picture_is_the_same_in_training_and_in_driving(dataset: FrameDataset) -> None:
    for i in range(len(dataset)):
        pictures = {"road": (0.0, dataset.jpeg(i))}
        sensed = Sensed(step=0, time_s=0.0, pictures=pictures, encoders=NO_TICKS, imu=NO_TURNS)
        seen = observation_of(sensed).pictures["road"].rgb
        assert seen.dtype == np.uint8 and seen.shape == (120, 160, 3) and seen.flags.c_contiguous
        assert np.array_equal(seen, dataset.picture(i))


@pytest.mark.parametrize("data", [b"", b"no picture", b"\xff\xd8\xff\xe0"])
def test_what_is_no_picture_is_none(data: bytes) -> None:
    assert decode_picture(data) is None
