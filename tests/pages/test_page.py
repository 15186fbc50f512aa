"""Pages hold what they show, say it as it was said, and are the same each time."""

import base64
import re
from html.parser import HTMLParser

import cv2
import numpy as np
import pytest
from matplotlib.figure import Figure

from adc_bench.pages import figure, grid, report, table
from adc_bench.pages.drawing import INKS, png

SLY = "a < b & \"c\" > 'd' $e ${f}"
OPEN = {"meta", "link", "img", "source"}  # never closed


class Read(HTMLParser):
    """A page's words, and its elements, each closed where it must be."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.words, self.seen, self.within = [""], [""], [""]
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append(tag)
        if tag not in OPEN:
            self.within.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.within.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def draw(drawn: Figure) -> None:
    axes = drawn.subplots()
    axes.plot([0, 1], [0, 1], label="line")


@pytest.fixture(scope="module")
def pngs() -> tuple[bytes, bytes]:
    return png(draw, INKS["light"]), png(draw, INKS["dark"])


def test_a_report_says_what_it_was_told_and_needs_nothing_beside_itself(pngs: tuple[bytes, bytes]) -> None:
    parts = (table(SLY, SLY, (SLY, "2"), [(SLY, SLY), ("x", "1")]), figure(SLY, *pngs))
    page = report(SLY, SLY, grid(parts)).decode()
    assert page == report(SLY, SLY, grid(parts)).decode()
    read = Read(page)
    assert read.within == [""] and read.words.count(SLY) == 9
    assert [read.seen.count(tag) for tag in ("title", "h1", "section", "tr", "td", "picture")] == [1, 1, 1, 3, 2, 1]
    assert not re.search(r'(src|srcset|href)="(?!data:)', page)
    held = re.findall(r'src(?:set)?="data:image/png;base64,([^"]+)"', page)
    assert {base64.b64decode(data) for data in held} == set(pngs)


@pytest.mark.parametrize(("columns", "wide"), [(5, False), (6, True)])
def test_a_table_of_many_columns_takes_the_whole_width(columns: int, wide: bool) -> None:
    assert ('class="wide"' in table("t", "n", ["c"] * columns, [["r"] * columns])) == wide


def test_ink_is_seen_on_its_paper_and_the_paper_shows_through(pngs: tuple[bytes, bytes]) -> None:
    light, dark = (cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) for data in pngs)
    assert light.shape == dark.shape and light.shape[2] == 4
    corner = light[:3, :3, 3]
    assert not corner.any()
    opaque = light[..., 3] == 255
    assert light[opaque][:, :3].min() < 60 and dark[opaque][:, :3].max() > 220


def test_a_figure_is_the_same_each_time(pngs: tuple[bytes, bytes]) -> None:
    assert png(draw, INKS["light"]) == pngs[0]
