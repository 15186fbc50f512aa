"""The site's files, and its pages in a real browser: by mouse and keyboard, wide and narrow, with no net."""

import json
import re
import shutil
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import pytest
from made_board import SHOUT
from playwright.sync_api import Browser, Page, sync_playwright

from adc_bench import leaderboard
from adc_bench.cli.main import main
from adc_bench.errors import InputError

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
PHONE = {"viewport": {"width": 360, "height": 740}}
POOR = "entries/poor-d1.html"

needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="no chromium in the path (as root, make test installs it)")


@pytest.fixture(scope="module")
def site(whole_board: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("site") / "site"
    with pytest.raises(SystemExit) as done:
        main(["leaderboard", "site", "--out", str(out), "--leaderboard", str(whole_board)])
    assert done.value.code == 0
    return out


def test_every_entry_has_a_page_and_every_link_a_file(site: Path) -> None:
    names = {path.relative_to(site).as_posix() for path in site.rglob("*") if path.is_file()}
    entries = {f"entries/{name}-d1.html" for name in ("quick", "slow", "poor")}
    assert names == {"index.html", "style.css", "board.js", "replay.js", "leaderboard.json", "schema.json", *entries}
    for page in site.rglob("*.html"):
        for link in re.findall(r'(?:href|src)="([^"#]+)', page.read_text()):
            assert link == "data:," or (page.parent / link).resolve().is_file(), link


def test_equal_boards_give_equal_bytes(site: Path, whole_board: Path, tmp_path: Path) -> None:
    leaderboard.write_site(whole_board, tmp_path / "again")
    for path in (path for path in site.rglob("*") if path.is_file()):
        assert (tmp_path / "again" / path.relative_to(site)).read_bytes() == path.read_bytes()


def test_the_site_takes_the_place_of_an_older_one_only(whole_board: Path, tmp_path: Path) -> None:
    leaderboard.write_site(whole_board, tmp_path / "site")
    (tmp_path / "site" / "entries" / "gone-d1.html").write_text("an entry that is no more")
    leaderboard.write_site(whole_board, tmp_path / "site")
    assert not (tmp_path / "site" / "entries" / "gone-d1.html").exists()
    (tmp_path / "site" / "thesis.pdf").write_text("something else")
    with pytest.raises(InputError, match=r"a folder with thesis.pdf"):
        leaderboard.write_site(whole_board, tmp_path / "site")


def test_what_a_submission_said_is_text(site: Path) -> None:
    """Its traceback neither ends the page's script nor starts one of its own."""
    found: list[str] = []

    class Tags(HTMLParser):
        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            found.append(tag)

    text = (site / POOR).read_text()
    Tags().feed(text)
    assert "img" not in found and SHOUT not in text and "ValueError: &lt;/script&gt;" in text


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        yield browser
        browser.close()


@pytest.fixture
def opened(browser: Browser, site: Path, request: pytest.FixtureRequest) -> Iterator[Page]:
    """The page in a window of its own; in the end it must have complained of nothing and asked no net."""
    name, options = getattr(request, "param", ("index.html", {}))
    context = browser.new_context(**options)
    page = context.new_page()
    told: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: told.append(message.text))
    page.on("pageerror", lambda error: told.append(str(error)))
    page.on("request", lambda one: asked.append(one.url))
    page.goto((site / name).as_uri())
    yield page
    context.close()
    assert told == [] and [url for url in asked if not url.startswith(("file:", "data:"))] == []


def rows(page: Page) -> list[str]:
    return page.locator("table.sortable tbody tr:visible th a").all_text_contents()


@needs_browser
def test_headings_sort_and_say_so(opened: Page) -> None:
    assert rows(opened) == ["quick", "slow", "poor"]
    head = opened.locator("table.sortable thead th", has_text="points")
    head.locator("button").click()
    assert head.get_attribute("aria-sort") == "descending" and rows(opened) == ["quick", "slow", "poor"]
    head.locator("button").click()
    assert head.get_attribute("aria-sort") == "ascending" and rows(opened) == ["poor", "slow", "quick"]
    opened.locator("table.sortable thead th button", has_text="submission").click()
    assert rows(opened) == ["poor", "quick", "slow"]
    assert opened.locator("table.sortable thead th[aria-sort]").count() == 1
    opened.locator("table.sortable thead th button", has_text="lap time").click()
    assert rows(opened)[0] == "quick"  # the only one with a lap: what is missing comes last, either way
    opened.locator("table.sortable thead th button", has_text="lap time").click()
    assert rows(opened)[0] == "quick"


@needs_browser
def test_filters_leave_what_they_say(opened: Page) -> None:
    output = opened.locator("#filters output")
    assert output.text_content() == "3 entries"
    opened.select_option("select[name=suite]", "d1")
    opened.select_option("select[name=kind]", "driver")
    assert rows(opened) == ["quick", "slow", "poor"]
    opened.evaluate("document.querySelector('tr[data-kind]').dataset.kind = 'other'")
    opened.select_option("select[name=kind]", "")
    opened.select_option("select[name=kind]", "driver")
    assert rows(opened) == ["slow", "poor"] and output.text_content() == "2 entries"


@needs_browser
def test_the_keyboard_alone_sorts_and_follows(opened: Page) -> None:
    opened.keyboard.press("Tab")
    assert opened.evaluate("document.activeElement.className") == "skip"
    head = opened.locator("table.sortable thead button", has_text="collisions")
    while not head.evaluate("one => one === document.activeElement"):
        opened.keyboard.press("Tab")
    assert head.evaluate("one => getComputedStyle(one).outlineStyle") != "none"
    opened.keyboard.press("Enter")
    assert rows(opened)[-1] == "poor"
    link = opened.locator("table.sortable th a", has_text="poor")
    while not link.evaluate("one => one === document.activeElement"):
        opened.keyboard.press("Tab")
    opened.keyboard.press("Enter")
    opened.wait_for_url("**/poor-d1.html")
    assert opened.locator("h1").text_content() == "poor on d1"


@needs_browser
@pytest.mark.parametrize("opened", [(POOR, {})], indirect=True)
def test_the_slider_moves_the_robot_to_where_it_was(opened: Page, site: Path, whole_board: Path) -> None:
    trace = json.loads((whole_board / "traces" / "poor-d1.jsonl").read_text().splitlines()[0])
    run = opened.locator("article:visible")
    run.locator("input[type=range]").fill("2")
    place = re.findall(r"[-\d.]+", str(run.locator(".robot.truth").get_attribute("transform")))
    assert [float(value) for value in place[:2]] == pytest.approx([trace["x_mm"][8] / 1000, trace["y_mm"][8] / 1000])
    assert "2.00 s of 3.00 s, estimate 2.0 cm off" in str(run.locator(".now").text_content())
    cursor, plot = (run.locator(f".chart .{name}").first.bounding_box() for name in ("cursor", "plot"))
    assert cursor and plot
    assert (cursor["x"] - plot["x"]) / plot["width"] == pytest.approx(2 / 3, abs=0.01)


@needs_browser
@pytest.mark.parametrize("opened", [(POOR, {})], indirect=True)
def test_play_runs_to_the_end_and_the_keyboard_steps(opened: Page) -> None:
    run = opened.locator("article:visible")
    run.locator("select").select_option("16")
    run.locator(".play").press("Enter")
    opened.wait_for_function("document.querySelector('article:not([hidden]) input[type=range]').value === '3'")
    opened.wait_for_function("document.querySelector('article:not([hidden]) .play').textContent === 'Play'")
    slider = run.locator("input[type=range]")
    slider.press("ArrowLeft")
    assert slider.input_value() == "2.95" and "2.95 s of 3.00 s" in str(slider.get_attribute("aria-valuetext"))


@needs_browser
@pytest.mark.parametrize("opened", [(POOR, {})], indirect=True)
def test_runs_are_chosen_and_tell_why_they_ended(opened: Page) -> None:
    assert opened.locator("article:visible").get_attribute("id") == "run-d1-7001"
    opened.locator("table.runs a", has_text="d1-7003").click()
    run = opened.locator("article:visible")
    assert run.get_attribute("id") == "run-d1-7003" and SHOUT in str(run.locator(".detail").text_content())
    opened.select_option("select[name=run]", "run-d1-7002")
    run = opened.locator("article:visible")
    assert run.locator(".map .fault title").all_text_contents() == ["2.50 s: collision: cone 3"]
    run.locator(".events button", has_text="2.50 s").click()
    assert run.locator("input[type=range]").input_value() == "2.5"


@needs_browser
@pytest.mark.parametrize("opened", [("index.html", PHONE), (POOR, PHONE), (POOR, {})], indirect=True)
def test_no_page_is_wider_than_the_window(opened: Page) -> None:
    assert opened.evaluate("document.documentElement.scrollWidth <= innerWidth")


SCHEMES = [(name, {"color_scheme": scheme}) for name in ("index.html", POOR) for scheme in ("light", "dark")]


@needs_browser
@pytest.mark.parametrize("opened", SCHEMES, indirect=True)
def test_light_and_dark_are_readable(opened: Page) -> None:
    """The pages follow the system; every text stands out from its ground by WCAG's 4.5 : 1."""
    dark = opened.evaluate("matchMedia('(prefers-color-scheme: dark)').matches")
    paper = opened.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (luminance(paper) < 0.1) == dark
    faint = {
        (told, colour, ground)
        for told, colour, ground in opened.evaluate(TEXTS)
        if contrast(luminance(colour), luminance(ground)) < 4.5
    }
    assert faint == set()


TEXTS = """() => [...document.querySelectorAll("body *")]
  .filter((one) => one.checkVisibility() && [...one.childNodes].some((node) => node.nodeType === 3 && node.data.trim()))
  .map((one) => {
    const ground = (part) => getComputedStyle(part).backgroundColor;
    let under = one;
    while (ground(under) === "rgba(0, 0, 0, 0)" && under.parentElement) under = under.parentElement;
    return [one.textContent.slice(0, 30), getComputedStyle(one).color, ground(under)];
  })"""


def luminance(colour: str) -> float:
    """Return the relative luminance of a CSS colour, as WCAG defines it."""
    shares = [float(part) / 255 for part in re.findall(r"[\d.]+", colour)[:3]]
    linear = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(first: float, second: float) -> float:
    return (max(first, second) + 0.05) / (min(first, second) + 0.05)


@needs_browser
def test_without_scripts_all_runs_are_shown(browser: Browser, site: Path) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((site / POOR).as_uri())
    assert page.locator("article.run:visible").count() == 10
    assert page.locator(".player:visible").count() == 0
    context.close()
