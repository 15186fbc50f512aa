import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from adc_bench.detector.prepare import DEVIATION_FLOOR, prepare


@given(seed=st.integers(0, 10**6), height=st.integers(1, 70), width=st.integers(1, 70))
@settings(max_examples=30, deadline=None, derandomize=True)
def test_preparing_is_the_formula(seed: int, height: int, width: int) -> None:
    rgb = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    (x,) = prepare([rgb])
    assert x.dtype == np.float32 and x.shape == (3, -(-height // 32) * 32, -(-width // 32) * 32)
    exact = (rgb - rgb.mean()) / (rgb.std() + DEVIATION_FLOOR)
    assert np.allclose(x[:, :height, :width], exact.transpose(2, 0, 1), atol=1e-5)
    assert not x[:, height:].any() and not x[:, :, width:].any()


def test_preparing_undoes_the_level_of_light() -> None:
    bright = np.random.default_rng(0).integers(0, 120, (64, 96, 3), dtype=np.uint8)
    assert np.abs(np.subtract(*prepare([bright, bright * 2 + 10]))).max() < 0.15
    assert np.isfinite(prepare([np.zeros((50, 70, 3), np.uint8)])).all()
