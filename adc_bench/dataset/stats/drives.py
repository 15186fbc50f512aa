"""Charts of drives: how long, how far, how fast, what was driven and how."""

import numpy as np

from adc_bench.dataset.drive_log import DriveLog
from adc_bench.dataset.drive_recipe import BEHAVIOURS, MISSIONS
from adc_bench.dataset.stats.chart import Bars, Chart, Histogram

SPEED_EDGES_MPS = tuple(k / 10 for k in range(-5, 24, 2))  # standing still lies within a range


class DriveCharts:
    """Charts of a dataset of drives."""

    def __init__(self) -> None:
        self._missions = Bars("Missions", "mission", "drives")
        self._behaviours = Bars("Behaviours", "driver's behaviour", "drives")
        self._endings = Bars("Endings", "how it ended", "drives")
        self._durations = Histogram("Durations", "duration in s", "drives", (0, 5, 10, 15, 20, 25, 30, 35, 40, 60))
        self._lengths = Histogram("Lengths", "way driven in m", "drives", (0, 5, 10, 15, 20, 30, 40, 60, 80, 120))
        self._speeds = Histogram("Speeds", "speed in m/s, backwards below 0", "control steps", SPEED_EDGES_MPS)

    def add(self, log: DriveLog) -> None:
        """Add a drive."""
        time_s, poses = log.truth["time_s"], log.truth["pose_world_robot"]
        self._missions.add({log.script.mission: 1})
        self._behaviours.add({log.script.behaviour: 1})
        self._endings.add({log.script.ending or "unknown": 1})
        self._durations.add([time_s[-1] - time_s[0]])
        self._lengths.add([np.hypot(*np.diff(poses[:, :2], axis=0).T).sum()])
        self._speeds.add(log.truth["v_mps"])

    def charts(self) -> tuple[Chart, ...]:
        """Return the charts."""
        return (
            self._missions.chart(MISSIONS),
            self._behaviours.chart(BEHAVIOURS),
            self._endings.chart(),
            self._durations.chart(),
            self._lengths.chart(),
            self._speeds.chart(),
        )
