"""How fast to go for how well the place is known: a share of the wanted speed, the doubtfuller the less.

The share is continuous in the doubt, so that nothing switches to and fro, and never 0: a robot that stands sees nothing
new.
"""

import math
from dataclasses import dataclass

import numpy as np

from adc_bench.stack.ekf import Belief


@dataclass(frozen=True, kw_only=True)
class CautionParams:
    """The standard deviations of the place up to which it is driven at full speed and from which on at the least."""

    sure_m: float = 0.04
    lost_m: float = 0.10
    least_share: float = 0.15


def at_full_speed(belief: Belief) -> float:
    """Return 1 whatever the belief."""
    return 1.0


def carefully(belief: Belief) -> float:
    """Return the share of the wanted speed to go at: by the place's standard deviation where it is largest."""
    p = CautionParams()
    spread_m = math.sqrt(float(np.linalg.eigvalsh(belief.covariance[:2, :2])[-1]))
    return float(np.interp(spread_m, (p.sure_m, p.lost_m), (1.0, p.least_share)))
