"""The thesis' experiments in a reduced run: what is kept, and the figures against sums of the test's own."""

import base64
import json
import re
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest

from adc_bench.errors import InputError
from adc_bench.reproduce import Settings, reproduce
from adc_bench.world.course import Course

SETTINGS = Settings(
    laps=(("pid", 2.0), ("linearisation", 2.0)),
    robots=2,
    pixels_limit_s=1.5,
    approach_step_m=5.0,
    approach_lights=("normal", "bright"),
    boxes_s_m=((2.5,),),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("thesis")
    reproduce(out, SETTINGS)
    return out


def experiment(folder: Path, name: str) -> dict:
    return json.loads((folder / "experiments" / f"{name}.json").read_text())


def ours(folder: Path, title: str) -> dict:
    tables = json.loads((folder / "tables.json").read_text())["tables"]
    rows = next(table["rows"] for table in tables if table["title"] == title)
    return {row["what"]: row["ours"] for row in rows}


def errors_cm(estimate: dict) -> np.ndarray:
    pairs = zip(estimate["believed"], estimate["truth"], strict=True)
    return 100 * np.array([[b["x_m"] - t["x_m"], b["y_m"] - t["y_m"]] for b, t in pairs])


def test_laps_are_told_as_they_were_driven(folder: Path) -> None:
    lap, told = experiment(folder, "lap-pid-2.0"), ours(folder, "Laps")
    time_s, x_m = np.array(lap["time_s"]), np.array(lap["x_m"])
    # Over the start line: x from below to above 0 on the lane towards +x.
    over = [k for k in range(1, len(x_m)) if x_m[k - 1] < 0 <= x_m[k] and abs(lap["y_m"][k] + 2.6125) < 0.5]
    at_s = [float(np.interp(0.0, x_m[k - 1 : k + 1], time_s[k - 1 : k + 1])) for k in over]
    assert told["PID on the heading, 2.0 m/s: lap"] == pytest.approx(at_s[1] - at_s[0], abs=0.005)
    dense = Course().lap.sample(0.002)[:, :2]
    inside = (time_s >= at_s[0]) & (time_s <= at_s[1])
    away_m = [np.hypot(*(dense - place).T).min() for place in np.column_stack([x_m, lap["y_m"]])[inside]]
    assert told["PID on the heading, 2.0 m/s: largest deviation"] == pytest.approx(100 * max(away_m), abs=0.05)


def test_odometry_errors_are_those_of_the_files(folder: Path) -> None:
    worst_cm = np.array([np.abs(errors_cm(experiment(folder, f"odometry-{k}"))).max(axis=0) for k in range(2)])
    told = ours(folder, "Odometry alone")
    assert told["worst error in x"] == pytest.approx(worst_cm[0, 0], abs=1e-5)
    assert told["the same, worst of 2 robots"] == pytest.approx(worst_cm[:, 1].max(), abs=1e-5)


def test_simulated_landmarks_keep_the_filter_near_the_truth(folder: Path) -> None:
    estimate, told = experiment(folder, "filter"), ours(folder, "EKF with simulated landmarks")
    residuals_m = np.array([each["residual"] for each in estimate["seen"]])
    assert told["x: inside 10 cm"] == pytest.approx(100 * np.mean(np.abs(residuals_m[:, 0]) < 0.1), abs=1e-5)
    assert told["x: correlation with the next"] == pytest.approx(lag_one(residuals_m[:, 0]), abs=1e-5)
    assert told["y: inside 10 cm"] > 90
    away_cm = np.hypot(*errors_cm(estimate).T)
    assert told["position error, root mean square"] == pytest.approx(np.sqrt(np.mean(away_cm**2)), abs=1e-5)
    reckoned_cm = np.hypot(*errors_cm(experiment(folder, "odometry-0")).T)
    assert away_cm.max() < reckoned_cm.max()


def lag_one(values: np.ndarray) -> float:
    away = values - np.mean(values)
    return float(np.correlate(away, away, "full")[len(away)] / np.sum(away**2))


def test_landmarks_seen_lie_round_those_of_the_map(folder: Path) -> None:
    seen = experiment(folder, "filter")["seen"]
    circles = np.array([each["place_world"] for each in seen if each["kind"] == "circle"])
    assert np.hypot(np.abs(circles[:, 0]) - 5.35, circles[:, 1]).max() < 0.4
    corners = np.array([each["place_world"] for each in seen if each["kind"] == "corner"])
    known = Course().crosswalk_corners
    assert np.hypot(*(corners[:, None] - known).T).min(axis=0).max() < 0.4


def test_a_box_is_gone_round_without_touching_it(folder: Path) -> None:
    run, told = experiment(folder, "boxes-0"), ours(folder, "Going round boxes")
    assert told["one box: passed"] == "yes" and told["one box: contacts"] == 0
    assert told["one box: least distance"] == pytest.approx(100 * min(run["clearance_m"]), abs=1e-5)
    beside = min(run["truth"], key=lambda pose: abs(pose["x_m"] - 2.5))
    assert beside["y_m"] > -2.6125 + 0.4
    assert any(run["avoiding"]) and not run["avoiding"][-1]


def test_a_robot_that_waits_for_the_arrow_believes_its_start(folder: Path) -> None:
    away_cm = np.hypot(*errors_cm(experiment(folder, "pixels")).T)
    assert len(away_cm) > 40 and away_cm.max() < 5


def test_figures_stand_beside_the_page_and_in_it(folder: Path) -> None:
    files = sorted((folder / "figures").glob("*.png"))
    assert len(files) == 11
    page = (folder / "index.html").read_text()
    held = re.findall(r'src(?:set)?="data:image/png;base64,([^"]+)"', page)
    assert len(held) == 2 * len(files)
    assert {file.read_bytes() for file in files} <= {base64.b64decode(data) for data in held}
    assert not re.search(r'(src|href)="(?!data:)', page)
    for file in files:
        picture = cv2.imread(str(file))
        assert picture.shape[1] > 600 and picture.std() > 5


def test_what_is_there_is_kept_and_what_is_missing_driven_to_the_same_bytes(folder: Path) -> None:
    before = {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}
    for name in ("lap-linearisation-2.0", "filter"):
        (folder / "experiments" / f"{name}.json").unlink()
    (folder / "tables.json").unlink()
    kept = {path: path.stat().st_mtime_ns for path in (folder / "experiments").glob("*.json")}
    heard: list[tuple[int, int, str]] = []
    reproduce(folder, SETTINGS, tell=lambda *told: heard.append(told))
    assert {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()} == before
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    assert [done for done, _, _ in heard] == list(range(heard[0][1] + 1))


def test_other_settings_need_another_folder(folder: Path) -> None:
    with pytest.raises(InputError, match="other settings") as caught:
        reproduce(folder, msgspec.structs.replace(SETTINGS, seed=1))
    assert "name another --out" in str(caught.value)


def test_a_damaged_experiment_is_named(tmp_path: Path, folder: Path) -> None:
    for path in (folder / "run.json", folder / "experiments" / "lap-pid-2.0.json"):
        copy = tmp_path / path.relative_to(folder)
        copy.parent.mkdir(exist_ok=True)
        copy.write_bytes(path.read_bytes())
    (tmp_path / "experiments" / "lap-pid-2.0.json").write_text('{"time_s": [')
    with pytest.raises(InputError, match=r"lap-pid-2\.0\.json"):
        reproduce(tmp_path, SETTINGS)
