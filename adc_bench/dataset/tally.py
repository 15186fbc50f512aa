"""Counting what a dataset holds, shard by shard."""

from collections import Counter

import numpy as np

from adc_bench.dataset.layout import DriveCounts, Kind, Summary
from adc_bench.dataset.shard import Shard
from adc_bench.world.categories import CATEGORIES


class Tally:
    """The counts so far; shards are added in order, so that an arena that two of them share counts once."""

    def __init__(self) -> None:
        self._frames = self._scenarios = self._tunnel = self._ignored = self._drives = 0
        self._simulated_s = self._distance_m = 0.0
        self._cameras: Counter[str] = Counter()
        self._levels: Counter[str] = Counter()
        self._boxes: Counter[int] = Counter()
        self._last_scenario = b""

    def add(self, shard: Shard) -> None:
        """Count a shard's frames."""
        conditions, labels = shard.condition_columns, shard.label_columns
        scenarios = np.concatenate([[self._last_scenario], conditions["scenario"]])
        self._last_scenario = scenarios[-1]
        self._scenarios += int(np.count_nonzero(scenarios[1:] != scenarios[:-1]))
        self._frames += len(shard)
        self._tunnel += int(conditions["in_tunnel"].sum())
        self._ignored += int(labels["ignore"].sum())
        self._cameras.update(shard.cameras)
        self._levels.update(conditions["light_level"].astype(str).tolist())
        self._boxes.update(labels["category_id"][~labels["ignore"]].tolist())

    def add_drive(self, shard: Shard) -> None:
        """Count a drive's frames, time and way."""
        self.add(shard)
        time_s, poses = shard.truth()
        self._drives += 1
        self._simulated_s += float(time_s[-1] - time_s[0])
        self._distance_m += float(np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1).sum())

    def summary(self, kind: Kind, size_bytes: int) -> Summary:
        """Return the counts."""
        driving = DriveCounts(
            drives=self._drives, simulated_s=round(self._simulated_s, 3), distance_m=round(self._distance_m, 3)
        )
        return Summary(
            frames=self._frames,
            scenarios=self._scenarios,
            size_bytes=size_bytes,
            tunnel_frames=self._tunnel,
            ignored=self._ignored,
            cameras=dict(sorted(self._cameras.items())),
            light_levels=dict(sorted(self._levels.items())),
            boxes={name: self._boxes[id_] for id_, name in enumerate(CATEGORIES, start=1) if self._boxes[id_]},
            driving=driving if kind == "drives" else None,
        )
