"""The pages in a real browser: marks and filters that work, by mouse and keyboard, wide and narrow, with no net."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from adc_bench.dataset import FrameDataset
from adc_bench.dataset.preview import page_of
from adc_bench.dataset.stats import page_of as stats_page_of
from adc_bench.dataset.stats import statistics_of

CHROMIUM = shutil.which("chromium")
ARGUMENTS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
MARKS = {
    "b": ("boxes", ".box"),
    "a": ("amodals", ".amodal"),
    "m": ("masks", ".mask"),
    "p": ("keypoints", ".keypoint"),
    "l": ("lines", ".lane"),
    "n": ("names", ".name"),
}
PHONE = {"width": 360, "height": 740}

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium in the path (as root, make test installs it)")


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def pages(rendered: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pages")
    dataset = FrameDataset(rendered)
    (folder / "preview.html").write_bytes(page_of(dataset, 12))
    (folder / "stats.html").write_bytes(stats_page_of(statistics_of(dataset)))
    return folder


@pytest.fixture
def opened(browser: Browser, pages: Path, request: pytest.FixtureRequest) -> Iterator[Page]:
    """The page of this name in a window of its own; in the end it must have complained of nothing and asked no net."""
    name, options = getattr(request, "param", ("preview", {}))
    context = browser.new_context(**options)
    page = context.new_page()
    told: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: told.append(message.text))
    page.on("pageerror", lambda error: told.append(str(error)))
    page.on("request", lambda one: asked.append(one.url))
    page.goto((pages / f"{name}.html").as_uri())
    yield page
    context.close()
    assert told == [] and [url for url in asked if not url.startswith(("file:", "data:"))] == []


def shown(page: Page, selector: str) -> int:
    return page.locator(f"figure:not([hidden]) {selector}:visible").count()


def test_check_boxes_and_keys_switch_each_mark(opened: Page) -> None:
    for key, (name, selector) in MARKS.items():
        box = opened.locator(f"input[name={name}]")
        box.set_checked(True)
        assert shown(opened, selector) > 0, name
        box.set_checked(False)
        assert shown(opened, selector) == 0, name
        opened.keyboard.press(key)
        assert box.is_checked() and shown(opened, selector) > 0, name


def test_ignore_regions_are_shown_when_asked_for(opened: Page) -> None:
    before = shown(opened, ".box")
    assert shown(opened, ".ignored .box") == 0
    opened.keyboard.press("i")
    assert shown(opened, ".box") == before + shown(opened, ".ignored .box") > before


@pytest.mark.parametrize("name", ["level", "camera", "tunnel", "layout", "categories"])
def test_filters_leave_what_they_say(opened: Page, name: str) -> None:
    every = opened.eval_on_selector_all("figure", "all => all.map(one => ({...one.dataset}))")
    for value in sorted({value for data in every for value in data[name].split()}):
        opened.select_option(f"select[name={name}]", value)
        left = opened.eval_on_selector_all("figure:not([hidden])", "all => all.map(one => ({...one.dataset}))")
        assert left == [data for data in every if value in data[name].split()]
        assert opened.locator("output").text_content() == (f"{len(left)} pictures" if len(left) > 1 else "1 picture")


def test_filters_add_up_and_let_go(opened: Page) -> None:
    opened.select_option("select[name=camera]", "road")
    opened.select_option("select[name=tunnel]", "out")
    assert 0 < opened.locator("figure:visible").count() <= 6
    opened.select_option("select[name=camera]", "")
    opened.select_option("select[name=tunnel]", "")
    assert opened.locator("figure:visible").count() == 12


def test_the_keyboard_alone_is_enough(opened: Page) -> None:
    """j and k walk over the pictures that are left, Enter enlarges, Tab and Space reach the check boxes."""
    opened.select_option("select[name=camera]", "panel")
    opened.locator("select[name=camera]").blur()
    opened.keyboard.press("j")
    opened.keyboard.press("j")
    second = opened.locator("figure:visible").nth(1)
    assert second.evaluate("one => one === document.activeElement")
    small = second.bounding_box()["width"]
    opened.keyboard.press("Enter")
    assert second.bounding_box()["width"] > 1.3 * small
    opened.keyboard.press("Enter")
    assert second.bounding_box()["width"] == small
    opened.keyboard.press("k")
    assert opened.locator("figure:visible").first.evaluate("one => one === document.activeElement")
    opened.locator("input[name=boxes]").focus()
    opened.keyboard.press("Space")
    assert not opened.locator("input[name=boxes]").is_checked() and shown(opened, ".box") == 0
    opened.keyboard.press("Tab")
    assert opened.locator("input[name=amodals]").evaluate("one => one === document.activeElement")


def test_the_size_can_be_chosen(opened: Page) -> None:
    small = opened.locator("figure").first.bounding_box()["width"]
    opened.locator("input[name=wide]").fill("60")
    assert opened.locator("figure").first.bounding_box()["width"] > 1.5 * small


def test_marks_lie_on_the_picture(opened: Page) -> None:
    picture = opened.locator(".picture").first
    frame = picture.bounding_box()
    assert picture.locator("img").bounding_box() == picture.locator("svg").bounding_box() == frame
    assert frame["width"] / frame["height"] == pytest.approx(320 / 240, rel=0.01)
    assert picture.locator("img").evaluate("one => [one.naturalWidth, one.naturalHeight]") == [320, 240]


NARROW = [
    ("preview", {"viewport": PHONE}),
    ("stats", {"viewport": PHONE}),
    ("stats", {"viewport": {"width": 1280, "height": 800}}),
]


@pytest.mark.parametrize("opened", NARROW, indirect=True)
def test_no_page_is_wider_than_the_window(opened: Page) -> None:
    assert opened.evaluate("document.documentElement.scrollWidth <= innerWidth")


SCHEMES = [(name, {"color_scheme": scheme}) for name in ("preview", "stats") for scheme in ("light", "dark")]


@pytest.mark.parametrize("opened", SCHEMES, indirect=True)
def test_light_and_dark_follow_the_system(opened: Page, request: pytest.FixtureRequest) -> None:
    dark = opened.evaluate("matchMedia('(prefers-color-scheme: dark)').matches")
    colours = opened.evaluate("(s => [s.color, s.backgroundColor])(getComputedStyle(document.body))")
    ink, paper = (sum(int(part) for part in colour.strip("rgb()").split(",")) for colour in colours)
    assert (ink > paper + 300) if dark else (paper > ink + 300)
