"""`dataset stats`: every number counted again one label at a time; text, picture and page show them."""

import json
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from adc_bench.cli.main import app
from adc_bench.dataset import FrameDataset
from adc_bench.dataset.stats import Statistics, page_of, picture_of, statistics_of, text_of
from adc_bench.dataset.stats.chart import Chart, Histogram
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Label


@pytest.fixture(scope="module")
def found(rendered: Path) -> Statistics:
    return statistics_of(FrameDataset(rendered))


@pytest.fixture(scope="module")
def labels(rendered: Path) -> list[Label]:
    dataset = FrameDataset(rendered)
    return [label for i in range(len(dataset)) for label in dataset.annotations(i)]


def chart(found: Statistics, title: str) -> Chart:
    return next(chart for chart in found.charts if chart.title == title)


def counts(chart: Chart, series: str = "") -> dict[str, int]:
    return {row: count for row, count in zip(chart.rows, chart.series[series], strict=True) if count}


def test_categories_and_sizes_are_those_of_the_labels(found: Statistics, labels: list[Label]) -> None:
    for series, ignored in (("labelled", False), ("ignore region", True)):
        names = Counter(CATEGORIES[label.category_id - 1] for label in labels if label.ignore is ignored)
        assert counts(chart(found, "Categories"), series) == names
    kept = [label.visible_px for label in labels if not label.ignore]
    sizes = Counter("small" if area < 1024 else "medium" if area < 9216 else "large" for area in kept)
    assert counts(chart(found, "Sizes")) == sizes and found.labels == len(labels)


@pytest.mark.parametrize(
    ("title", "value"),
    [
        ("Heights", lambda label: label.box_px[3] - label.box_px[1]),
        ("Distances", lambda label: label.distance_m),
        ("Visible share", lambda label: label.visible_fraction),
        ("Truncation", lambda label: label.truncation),
    ],
)
def test_histograms_are_numpys(found: Statistics, labels: list[Label], title: str, value: object) -> None:
    one = chart(found, title)
    values = np.clip([value(label) for label in labels if not label.ignore], one.edges[0], one.edges[-1])
    assert one.series[""] == tuple(np.histogram(values, one.edges)[0])


def test_every_picture_is_in_every_chart_of_pictures(found: Statistics) -> None:
    assert all(sum(one.totals) == found.frames == 70 for one in found.charts if one.what == "pictures")
    assert counts(chart(found, "Cameras")) == {"road": 35, "panel": 35}
    assert found.scenarios == 5 or found.scenarios > 0


def test_values_beyond_the_ends_count_in_the_outer_ranges() -> None:
    histogram = Histogram("T", "x", "things", (0, 1, 2))
    histogram.add([-5.0, 0.0, 1.0, 2.0, 99.0])
    histogram.add([])
    assert histogram.chart().series == {"": (2, 3)} and histogram.chart().rows == ("0 to 1", "1 and more")


def test_the_text_has_every_number(found: Statistics) -> None:
    text = text_of(found)
    assert text.startswith("val (frames): 70 pictures of 320x240")
    assert all(one.title in text and all(row in text for row in one.rows) for one in found.charts)


def test_the_picture_is_the_same_each_time(found: Statistics) -> None:
    data = picture_of(found)
    assert data == picture_of(found)
    shown = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert shown.shape[1] == 1430 and shown.shape[0] > 1000


class Addresses(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [value or "" for name, value in attrs if name in ("src", "href")]


def test_the_page_has_every_row_and_no_address(found: Statistics) -> None:
    page = page_of(found).decode()
    addresses = Addresses()
    addresses.feed(page)
    assert page.count("<tr>") == sum(len(one.rows) + 1 for one in found.charts)
    assert all(address.startswith("data:") for address in addresses.found) and "http" not in page


def test_the_command(rendered: Path, tmp_path: Path) -> None:
    run = CliRunner().invoke(app, ["dataset", "stats", str(rendered), "--out", str(tmp_path), "--json"])
    assert run.exit_code == 0 and json.loads(run.stdout)["frames"] == 70
    assert {path.name for path in tmp_path.iterdir()} == {"stats.png", "stats.html"}
