"""What a few runs say about a figure: mean, spread, median and a bootstrap interval of the mean."""

from collections.abc import Sequence

import msgspec
import numpy as np

from adc_bench.world.streams import stream

RESAMPLES = 2000


class Statistic(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A figure over n runs; `sd` is the sample's (none for n = 1), `ci95` the percentile bootstrap of the mean."""

    mean: float
    sd: float | None
    median: float
    ci95: tuple[float, float]
    n: int
    unit: str
    higher_is_better: bool


def summarise(name: str, values: Sequence[float], *, unit: str, higher_is_better: bool) -> Statistic:
    """Return the statistic of at least one finite value; the resampling is seeded by the figure's name."""
    sample = np.asarray(values, dtype=np.float64)
    assert sample.size > 0 and np.isfinite(sample).all()
    draws = stream(0, "bootstrap", name).integers(sample.size, size=(RESAMPLES, sample.size))
    low, high = np.quantile(sample[draws].mean(axis=1), (0.025, 0.975))
    return Statistic(
        mean=float(sample.mean()),
        sd=float(sample.std(ddof=1)) if sample.size > 1 else None,
        median=float(np.median(sample)),
        ci95=(float(low), float(high)),
        n=sample.size,
        unit=unit,
        higher_is_better=higher_is_better,
    )
