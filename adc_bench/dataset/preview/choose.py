"""Which pictures of a dataset to look at: some of every light level, camera and layout, in the tunnel and out."""

from collections import Counter, defaultdict
from typing import NamedTuple

import numpy as np

from adc_bench.dataset.read import FrameDataset

_Kind = tuple[str, ...]  # light level, camera, layout, in the tunnel or not
PER_GROUP = 256
PICTURES_APART = 24  # in a drive: about a second, and another camera each time round


class _Candidate(NamedTuple):
    boxes: int
    frame: int
    scenario: str


def spread(dataset: FrameDataset, count: int) -> list[int]:
    """Return up to `count` frames in order: light levels, cameras, layouts, and in or out of the tunnel as evenly as
    they come, of equals those with the most boxes first and from different arenas; of a drive about one a second.

    Memory does not grow with the dataset.
    """
    groups: dict[_Kind, list[_Candidate]] = defaultdict(list)
    for start, shard in dataset.shards():
        offset, ignored = shard.label_columns["offset"], shard.label_columns["ignore"].astype(bool)
        kept = np.concatenate([[0], np.cumsum(~ignored)])
        for row in range(0, len(shard), PICTURES_APART if dataset.manifest.kind == "drives" else 1):
            camera = shard.cameras[row]
            conditions = shard.conditions(row)
            layout = shard.scenarios[conditions.scenario].layout.name
            group = groups[conditions.light_level, camera, layout, str(conditions.in_tunnel)]
            boxes = int(kept[offset[row + 1]] - kept[offset[row]])
            group.append(_Candidate(boxes, start + row, conditions.scenario))
            if len(group) > 2 * PER_GROUP:
                group[:] = _best(group)
    waiting = {kind: _best(group)[::-1] for kind, group in sorted(groups.items())}
    taken: Counter[tuple[int, str]] = Counter()
    chosen: list[int] = []
    while waiting and len(chosen) < count:
        kind = min(waiting, key=lambda kind: sum(taken[feature] for feature in enumerate(kind)))
        taken.update(enumerate(kind))
        chosen.append(waiting[kind].pop().frame)
        if not waiting[kind]:
            del waiting[kind]
    return sorted(chosen)


def _best(group: list[_Candidate]) -> list[_Candidate]:
    """Return a group's candidates, best first: each arena's first, then each one's second, and so on."""
    seen: dict[str, int] = defaultdict(int)
    ranked: list[tuple[int, int, _Candidate]] = []
    for place, one in enumerate(sorted(group, key=lambda one: (-one.boxes, one.frame))):
        ranked.append((seen[one.scenario], place, one))
        seen[one.scenario] += 1
    return [one for *_, one in sorted(ranked)[:PER_GROUP]]
