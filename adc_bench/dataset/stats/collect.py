"""The statistics of a dataset, from its columns, a shard at a time: memory does not grow with the dataset."""

from collections import Counter
from collections.abc import Callable

import msgspec
import numpy as np

from adc_bench.dataset.columns import Columns
from adc_bench.dataset.drive_log import take_log
from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.shard import Shard, open_shard
from adc_bench.dataset.stats.chart import Bars, Chart, Histogram
from adc_bench.dataset.stats.drives import DriveCharts
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.look import LIGHT_LEVELS

CROWD = (*map(str, range(10)), "10 and more")
TENTHS = tuple(k / 10 for k in range(11))
SMALL_PX, LARGE_PX = 32**2, 96**2  # COCO's limits of an object's area


class Statistics(msgspec.Struct, frozen=True, kw_only=True):
    """What a dataset holds: whose it is, how much, and charts."""

    split: str
    kind: str
    width_px: int
    height_px: int
    frames: int
    scenarios: int
    labels: int
    size_bytes: int
    charts: tuple[Chart, ...]


def statistics_of(dataset: FrameDataset, progress: Callable[[int, int], None] = lambda done, total: None) -> Statistics:
    """Return the statistics; `progress` is told shards done and shards in all.

    Raises:
        InputError: a shard cannot be read.
    """
    boxes, pictures = BoxCharts(), PictureCharts()
    drives = DriveCharts() if dataset.manifest.kind == "drives" else None
    total = len(dataset.manifest.shards)
    for number, (entry, (_, shard)) in enumerate(zip(dataset.manifest.shards, dataset.shards(), strict=True), start=1):
        boxes.add(shard.label_columns)
        pictures.add(shard)
        if drives:
            with open_shard(dataset.store, entry.file) as file:
                drives.add(take_log(file))
        progress(number, total)
    return Statistics(
        split=dataset.manifest.split.name,
        kind=dataset.manifest.kind,
        width_px=dataset.width_px,
        height_px=dataset.height_px,
        frames=len(dataset),
        scenarios=len(pictures.scenarios),
        labels=boxes.count,
        size_bytes=sum(entry.size_bytes for entry in dataset.manifest.shards),
        charts=(*boxes.charts(), *pictures.charts(), *(drives.charts() if drives else ())),
    )


class BoxCharts:
    """Charts of the labels; all but the first leave ignore regions out."""

    def __init__(self) -> None:
        self.count = 0
        self._categories = Bars("Categories", "category", "boxes")
        self._sizes = Bars("Sizes", "visible area (COCO)", "boxes")
        self._heights = Histogram(
            "Heights", "height in pixels", "boxes", (0, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)
        )
        self._distances = Histogram(
            "Distances", "distance in m", "boxes", (0, 0.5, 1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 12)
        )
        self._visible = Histogram("Visible share", "visible fraction", "boxes", TENTHS)
        self._truncation = Histogram("Truncation", "share outside the picture", "boxes", TENTHS)

    def add(self, columns: Columns) -> None:
        """Add a shard's labels."""
        ignored = columns["ignore"].astype(bool)
        self.count += len(ignored)
        names = np.array(CATEGORIES)[columns["category_id"] - 1]
        self._categories.add(Counter(names[~ignored].tolist()), "labelled")
        self._categories.add(Counter(names[ignored].tolist()), "ignore region")
        kept = {name: columns[name][~ignored] for name in ("box_px", "visible_px", "distance_m")}
        sizes = np.array(["small", "medium", "large"])[np.digitize(kept["visible_px"], (SMALL_PX, LARGE_PX))]
        self._sizes.add(Counter(sizes.tolist()))
        self._heights.add(kept["box_px"][:, 3] - kept["box_px"][:, 1])
        self._distances.add(kept["distance_m"])
        self._visible.add(columns["visible_fraction"][~ignored])
        self._truncation.add(columns["truncation"][~ignored])

    def charts(self) -> tuple[Chart, ...]:
        """Return the charts."""
        histograms = self._heights, self._distances, self._visible, self._truncation
        return (
            self._categories.chart(CATEGORIES),
            self._sizes.chart(("small", "medium", "large")),
            *(histogram.chart() for histogram in histograms),
        )


class PictureCharts:
    """Charts of the pictures: what is in them, the light, the cameras, the arenas."""

    def __init__(self) -> None:
        self.scenarios: set[str] = set()
        self._crowd = Bars("Boxes in a picture", "boxes", "pictures")
        self._lux = Histogram(
            "Light", "illuminance in lux", "pictures", (0, 10, 15, 25, 40, 60, 100, 150, 250, 400, 600, 1000, 1600)
        )
        self._shutter = Histogram(
            "Exposure time", "shutter in ms", "pictures", (0, 0.5, 1, 2, 4, 6, 8, 10, 12, 14, 16, 18)
        )
        self._exposure = Histogram(
            "Exposure",
            "exposure (1 shows white under 300 lux at full scale)",
            "pictures",
            (0, 0.125, 0.25, 0.5, 1, 2, 4, 8),
        )
        self._blur = Histogram("Motion blur", "mean blur in pixels", "pictures", (0, 0.1, 0.5, 1, 2, 3, 4, 6, 8, 12))
        self._bars = {
            "levels": Bars("Light levels", "light level", "pictures"),
            "cameras": Bars("Cameras", "camera", "pictures"),
            "tunnel": Bars("Tunnel", "where the camera is", "pictures"),
            "layouts": Bars("Layouts", "layout", "pictures"),
            "floors": Bars("Floors", "floor", "pictures"),
            "walls": Bars("Walls", "walls", "pictures"),
            "lights": Bars("Lighting", "way of lighting", "pictures"),
        }

    def add(self, shard: Shard) -> None:
        """Add a shard's pictures."""
        columns = shard.condition_columns
        crowd = np.minimum(_labels_kept(shard.label_columns), len(CROWD) - 1)
        self._crowd.add(Counter(CROWD[count] for count in crowd))
        self._lux.add(columns["illuminance_lux"])
        self._shutter.add(1000 * columns["shutter_s"])
        self._exposure.add(columns["exposure"])
        self._blur.add(columns["blur_px"])
        in_tunnel = int(columns["in_tunnel"].sum())
        self._bars["tunnel"].add({"in the tunnel": in_tunnel, "outside": len(shard) - in_tunnel})
        self._bars["levels"].add(Counter(columns["light_level"].astype(str).tolist()))
        self._bars["cameras"].add(Counter(shard.cameras))
        for name, count in Counter(columns["scenario"].astype(str).tolist()).items():
            self._add_scenario(shard, name, count)

    def _add_scenario(self, shard: Shard, name: str, count: int) -> None:
        self.scenarios.add(name)
        scenario = shard.scenarios[name]
        self._bars["layouts"].add({scenario.layout.name: count})
        self._bars["floors"].add({scenario.look.floor: count})
        self._bars["walls"].add({scenario.look.wall: count})
        self._bars["lights"].add({scenario.look.light_set: count})

    def charts(self) -> tuple[Chart, ...]:
        """Return the charts."""
        histograms = self._lux, self._exposure, self._shutter, self._blur
        orders = {"levels": tuple(LIGHT_LEVELS), "tunnel": ("outside", "in the tunnel")}
        return (
            self._crowd.chart(CROWD),
            *(histogram.chart() for histogram in histograms),
            *(bars.chart(orders.get(key, ())) for key, bars in self._bars.items()),
        )


def _labels_kept(columns: Columns) -> np.ndarray:
    """Return how many labels each frame has that are no ignore regions, (n,)."""
    before = np.concatenate([[0], np.cumsum(~columns["ignore"].astype(bool))])
    return np.diff(before[columns["offset"]])
