"""Intervals that cover what they promise, and a test that tells a difference from chance."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import bootstrap as scipy_bootstrap
from scipy.stats import norm, t

from adc_bench.evaluate.statistics import bootstrap_interval, compare, summarise

Draw = Callable[[np.random.Generator, int], np.ndarray]


def test_a_statistic_against_scipy() -> None:
    values = [1.0, 2.0, 4.0, 8.0, 9.0, 3.0, 5.5, 7.0]
    found = summarise("figure", values, unit="m", higher_is_better=False)
    level = 1 - 2 * norm.cdf(np.sqrt(8 / 7) * t.ppf(0.025, 7))
    theirs = scipy_bootstrap(
        (values,), np.mean, method="percentile", confidence_level=level, n_resamples=20000, rng=0
    ).confidence_interval
    assert (found.mean, found.median, found.n) == (4.9375, 4.75, 8)
    assert found.sd == pytest.approx(np.std(values, ddof=1))
    assert found.ci95 == pytest.approx((theirs.low, theirs.high), abs=0.25)
    assert found == summarise("figure", values, unit="m", higher_is_better=False)


def test_a_single_value_has_no_spread() -> None:
    found = summarise("figure", [2.5], unit="", higher_is_better=True)
    assert (found.mean, found.sd, found.ci95) == (2.5, None, (2.5, 2.5))


def covered(draw: Draw, truth: float, n: int, trials: int) -> float:
    """Return how often the interval of n made-up runs holds the mean that they were drawn with."""
    rng = np.random.default_rng(n)
    intervals = (bootstrap_interval(draw(rng, n), rng) for _ in range(trials))
    return sum(low <= truth <= high for low, high in intervals) / trials


@pytest.mark.parametrize(
    ("draw", "truth"),
    [
        (lambda rng, n: rng.normal(60.0, 5.0, n), 60.0),
        (lambda rng, n: rng.uniform(0.0, 100.0, n), 50.0),
        (lambda rng, n: 10.0 + rng.gamma(4.0, 1.0, n), 14.0),
    ],
    ids=["normal", "uniform", "skewed"],
)
def test_intervals_cover_nearly_what_they_promise(draw: Draw, truth: float) -> None:
    """95 % are promised; 400 trials have a standard error of 1.1 %."""
    assert 0.86 < covered(draw, truth, 5, 400) < 0.98
    assert 0.91 < covered(draw, truth, 10, 400) < 0.99


def test_an_interval_stays_among_its_values() -> None:
    low, high = bootstrap_interval(np.array([0.0, 100.0, 100.0, 100.0, 0.0]), np.random.default_rng(0))
    assert 0.0 <= low < 60.0 < high <= 100.0


def sign_flip_p(difference: np.ndarray) -> float:
    """Return the two-sided p-value from all sign flips, one by one."""
    means = [np.mean(difference * signs) for signs in itertools.product((-1, 1), repeat=difference.size)]
    return float(np.mean([abs(mean) >= abs(difference.mean()) - 1e-12 for mean in means]))


def by_seed(values: np.ndarray) -> dict[int, float]:
    return dict(enumerate(values.tolist()))


@pytest.mark.parametrize("shift", [0.0, 0.4, 3.0])
def test_a_comparison_against_all_sign_flips(shift: float) -> None:
    first, second = np.random.default_rng(3).standard_normal((2, 8))
    found = compare(by_seed(first + shift), by_seed(second))
    assert found.p_value == pytest.approx(sign_flip_p(first + shift - second))
    assert found.mean_difference == pytest.approx(float(np.mean(first + shift - second)))
    low, high = found.ci95
    assert low < found.mean_difference < high and found.n == 8


def test_a_comparison_is_fair_to_both() -> None:
    first, second = np.random.default_rng(4).normal(([0.6], [0.0]), 1.0, (2, 10))
    there, back = compare(by_seed(first), by_seed(second)), compare(by_seed(second), by_seed(first))
    assert there.p_value == back.p_value
    assert there.mean_difference == -back.mean_difference


def test_equals_and_single_runs_show_no_difference() -> None:
    same = by_seed(np.full(10, 100.0))
    assert (compare(same, same).p_value, compare(same, same).ci95) == (1.0, (0.0, 0.0))
    assert compare({7: 90.0}, {7: 10.0}).p_value == 1.0


def test_chance_is_called_a_difference_as_seldom_as_it_says() -> None:
    rng = np.random.default_rng(5)
    called = [compare(by_seed(rng.normal(size=8)), by_seed(rng.normal(size=8))).p_value <= 0.05 for _ in range(150)]
    assert np.mean(called) < 0.11
