"""Counts by name or by range of values: what the text, the picture and the page of `dataset stats` show."""

from collections import Counter
from collections.abc import Mapping, Sequence

import msgspec
import numpy as np
from numpy.typing import ArrayLike


class Chart(msgspec.Struct, frozen=True, kw_only=True):
    """Counts of `what` in `rows`: of each series as many numbers as there are rows.

    `edges` are the ranges' borders where the rows are ranges of a quantity (`axis` names it, with its unit).
    """

    title: str
    axis: str
    what: str
    rows: tuple[str, ...]
    series: dict[str, tuple[int, ...]]
    edges: tuple[float, ...] | None = None

    @property
    def totals(self) -> tuple[int, ...]:
        """The sum of all series in each row."""
        return tuple(sum(counts) for counts in zip(*self.series.values(), strict=True))


class Bars:
    """Counts names, in several series."""

    def __init__(self, title: str, axis: str, what: str) -> None:
        self._title, self._axis, self._what = title, axis, what
        self._counts: dict[str, Counter[str]] = {}

    def add(self, names: Mapping[str, int], series: str = "") -> None:
        """Add so many of each name."""
        self._counts.setdefault(series, Counter()).update(names)

    def chart(self, order: Sequence[str] = ()) -> Chart:
        """Return the chart: names in the order given, others after them by the alphabet."""
        seen = set().union(*self._counts.values())
        rows = (*(name for name in order if name in seen), *sorted(seen - set(order)))
        series = {name: tuple(counts[row] for row in rows) for name, counts in self._counts.items()}
        return Chart(title=self._title, axis=self._axis, what=self._what, rows=rows, series=series)


class Histogram:
    """Counts values in ranges, in several series; what lies beyond the ends is counted in the first or last range."""

    def __init__(self, title: str, axis: str, what: str, edges: Sequence[float]) -> None:
        self._title, self._axis, self._what = title, axis, what
        self._edges = np.asarray(edges, dtype=np.float64)
        self._counts: dict[str, np.ndarray] = {}

    def add(self, values: ArrayLike, series: str = "") -> None:
        """Add values, in the axis' unit."""
        places = np.searchsorted(self._edges, np.asarray(values, dtype=np.float64), side="right") - 1
        counts = np.bincount(np.clip(places, 0, len(self._edges) - 2), minlength=len(self._edges) - 1)
        self._counts[series] = self._counts.get(series, 0) + counts

    def chart(self) -> Chart:
        """Return the chart."""
        edges = self._edges.tolist()
        last = len(edges) - 2
        rows = [_range(edges[k], edges[k + 1], open_end=k == last) for k in range(last + 1)]
        series = {name: tuple(int(count) for count in counts) for name, counts in self._counts.items()}
        return Chart(
            title=self._title,
            axis=self._axis,
            what=self._what,
            rows=tuple(rows),
            series=series or {"": (0,) * len(rows)},
            edges=tuple(edges),
        )


def _range(low: float, high: float, *, open_end: bool) -> str:
    return f"{low:g} and more" if open_end else f"{low:g} to {high:g}"
