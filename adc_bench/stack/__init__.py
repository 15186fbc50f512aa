"""The driving stack on numpy, OpenCV and SciPy: bird's-eye view, landmarks, filters, pilots, agents.

It takes `detect` as a function and knows of the world only the map, the nominal robot and what the sensors say.
"""

from adc_bench.stack.driver import Driver
from adc_bench.stack.stand_still import StandStill

__all__ = ["Driver", "StandStill"]
