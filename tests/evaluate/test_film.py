"""Films of drives: that they show the run, play in a browser, and change nothing else."""

import shutil
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest
from made_runs import MakeSubmission, along_lap, header_of, log_of
from playwright.sync_api import sync_playwright

from adc_bench.errors import MachineError, UsageError
from adc_bench.evaluate.film import MAP_PX, ROAD_PX, SIZE_PX, Film
from adc_bench.evaluate.film_map import DRIVEN, ROBOT
from adc_bench.evaluate.log import EpisodeLog
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.run import evaluate_submission
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import Suite, load_suite, scenario_for

CHROMIUM = shutil.which("chromium")
GREY = bytes(cv2.imencode(".jpg", np.full((240, 320, 3), 90, np.uint8))[1])


@pytest.fixture(scope="module")
def one_run(short_suite: Suite) -> Suite:
    return msgspec.structs.replace(short_suite, start_delay_s=(0.1, 0.1), seeds=(1,))


@pytest.fixture(scope="module")
def log() -> EpisodeLog:
    """Two laps of d1, estimates beside the truth."""
    header = header_of()
    return log_of(header, along_lap(header, 2.0))


def film_of(log: EpisodeLog) -> Film:
    scenario = scenario_for(load_suite("d1"), log.header.seed)
    return Film(log=log, pictures=[None, GREY] + [GREY] * (len(log.rows) - 3), scenario=scenario)


def played(film: bytes, folder: Path) -> list[np.ndarray]:
    """Return the pictures of a film's file."""
    (folder / "film.mp4").write_bytes(film)
    reader = cv2.VideoCapture(str(folder / "film.mp4"))
    assert reader.get(cv2.CAP_PROP_FPS) == pytest.approx(10.0)
    pictures = []
    while True:
        there, picture = reader.read()
        if not there:
            return pictures
        pictures.append(picture)


def test_a_recorded_suite_has_a_film_a_drive_and_the_same_result(
    submission_of: MakeSubmission, one_run: Suite, hurried: Rules, tmp_path: Path
) -> None:
    """Recorded at once, and recorded when it was there already."""
    submission, at_once, later = submission_of("Straight"), tmp_path / "at-once", tmp_path / "later"
    evaluate_submission(submission, one_run, at_once, rules=hurried, in_process=True, record=True)
    evaluate_submission(submission, one_run, later, rules=hurried, in_process=True)
    assert not list((later / "films").iterdir())
    plain = (later / "result.json").read_bytes(), (later / "episodes" / "dev-1.jsonl").read_bytes()
    evaluate_submission(submission, one_run, later, rules=hurried, in_process=True, record=True)
    for out in (at_once, later):
        assert ((out / "result.json").read_bytes(), (out / "episodes" / "dev-1.jsonl").read_bytes()) == plain
    first, second = ((out / "films" / "dev-1.mp4").read_bytes() for out in (at_once, later))
    assert first == second
    rows = len(plain[1].splitlines()) - 2
    shown = played(first, tmp_path)
    assert len(shown) == len([*range(0, rows - 1, 2), rows - 1]) + 10
    left, top, width, height = ROAD_PX
    road = [picture[top : top + height, left : left + width].astype(int) for picture in (shown[0], shown[-1])]
    assert min(picture.std() for picture in road) > 10.0
    assert np.abs(road[0] - road[1]).mean() > 1.0, "it has moved"


def test_a_submission_that_never_starts_is_filmed_all_the_same(
    submission_of: MakeSubmission, one_run: Suite, hurried: Rules, tmp_path: Path
) -> None:
    result = evaluate_submission(
        submission_of("RaisesInStart"), one_run, tmp_path / "out", rules=hurried, in_process=True, record=True
    )
    assert result.episodes[0].reason == "start-raised"
    assert len(played((tmp_path / "out" / "films" / "dev-1.mp4").read_bytes(), tmp_path)) == 11


def near(picture: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    """Return the middles (x, y) of the pixels of a colour, in the film's picture."""
    rows, columns = np.nonzero(np.abs(picture.astype(int) - colour).max(axis=2) < 12)
    return np.column_stack([columns, rows])


def test_the_robot_is_drawn_where_it_is_and_its_way_behind_it(log: EpisodeLog) -> None:
    film = film_of(log)
    left, top, width, height = MAP_PX
    places = []
    for step in (100, 300, 500):
        picture = film.frame(step)[top : top + height, left : left + width]
        places.append(near(picture, ROBOT).mean(axis=0))
        ways = len(near(picture, DRIVEN))
        assert ways > 20
    truth = np.array([(log.rows[step].truth.x_m, -log.rows[step].truth.y_m) for step in (100, 300, 500)])
    scale = np.linalg.norm(places[1] - places[0]) / np.linalg.norm(truth[1] - truth[0])
    moved = np.array(places) - places[0]
    np.testing.assert_allclose(moved, (truth - truth[0]) * scale, atol=2.0)
    assert 15.0 < scale < 25.0


def test_what_happened_is_told_when_it_has(log: EpisodeLog) -> None:
    """The text's corner fills up; the ending is told by the last picture alone."""
    film, last = film_of(log), len(log.rows) - 1
    ink = [int((film.frame(step)[222:, 396:] > 60).any(axis=2).sum()) for step in (0, last // 2, last - 1, last)]
    assert ink == sorted(ink) and ink[0] < ink[1] and ink[2] < ink[3]


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium in the path (as root, make test installs it)")
def test_a_browser_plays_it(log: EpisodeLog, tmp_path: Path) -> None:
    film = film_of(msgspec.structs.replace(log, rows=log.rows[:41]))
    (tmp_path / "film.mp4").write_bytes(film.mp4())
    (tmp_path / "page.html").write_text('<video muted src="film.mp4"></video>')
    ready = """() => new Promise(done => { const film = document.querySelector("video");
        film.oncanplay = film.onerror = () => done([film.error?.message, film.duration, film.videoWidth]);
        if (film.readyState > 2 || film.error) film.oncanplay(); })"""
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--headless", "--no-sandbox"])
        page = browser.new_page()
        page.goto((tmp_path / "page.html").as_uri())
        fault, seconds, width = page.evaluate(ready)
        browser.close()
    assert fault is None
    assert (seconds, width) == (pytest.approx(3.1, abs=0.15), SIZE_PX[0])


def test_an_opencv_without_the_encoder_is_told(log: EpisodeLog, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("adc_bench.evaluate.film.CODEC", "none")
    with pytest.raises(MachineError) as caught:
        film_of(log).mp4()
    assert "no encoder for VP9 in MP4" in str(caught.value) and "leave --record out" in str(caught.value)


def test_what_is_not_driven_cannot_be_recorded(tmp_path: Path) -> None:
    submission = load_submission("odometry-only", {}, kind="localizer")
    with pytest.raises(UsageError) as caught:
        evaluate_submission(submission, load_suite("loc"), tmp_path / "out", record=True)
    assert "suite loc, in which nothing is driven" in str(caught.value)
    assert not (tmp_path / "out").exists()
