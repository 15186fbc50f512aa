"""Errors as two figures, and figures as files hold them."""

import math

import msgspec
import numpy as np
from numpy.typing import ArrayLike

DECIMALS = 6  # the last bits of a sum differ between machines


class Spread(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How large errors are, in their unit; None where there are none."""

    count: int
    median: float | None
    p95: float | None


def spread_of(errors: ArrayLike) -> Spread:
    """Return the median and the 95th percentile of errors (n,)."""
    values = np.asarray(errors, np.float64)
    median, p95 = (rounded(np.quantile(values, q)) for q in (0.5, 0.95)) if len(values) else (None, None)
    return Spread(count=len(values), median=median, p95=p95)


def share(part: int | np.integer, whole: int | np.integer) -> float | None:
    """Return a share of the whole, None of nothing."""
    return rounded(part / whole) if whole else None


def rounded(value: float | np.floating) -> float:
    """Return the figure as files hold it."""
    assert math.isfinite(value)
    return round(float(value), DECIMALS)
