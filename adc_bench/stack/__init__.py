"""The driving stack on numpy and OpenCV: bird's-eye view, landmarks, EKF, path following, agents.

It takes `detect` as a function and knows of the world only the map, the nominal robot and what the sensors say.
"""

from adc_bench.stack.driver import Driver, DriverParams
from adc_bench.stack.stand_still import StandStill

__all__ = ["Driver", "DriverParams", "StandStill"]
