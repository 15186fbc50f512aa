"""Datasets of drives: the same bytes however they are made, labelled pictures at their times, truth and TUM alike."""

import itertools
import re
import shutil
from pathlib import Path

import h5py
import msgspec
import numpy as np
import pytest

from adc_bench.dataset import FrameDataset, Split, load_split
from adc_bench.dataset.drive_log import GROUPS
from adc_bench.dataset.drives import DriveDataset
from adc_bench.dataset.driving.plan import draw_drive
from adc_bench.dataset.preview.choose import spread
from adc_bench.errors import InputError
from adc_bench.generate import render_split
from adc_bench.generate.drives import render_drive, simulate
from adc_bench.generate.plan import ShardTask, plan_dataset, plan_renderer
from adc_bench.geometry import Pose3
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.sensors import SensorRig

SIZE = (160, 120)


def short(split: Split) -> Split:
    recipe = msgspec.structs.replace(
        split.drives, duration_s=(3.0, 3.5), missions={"obstacles": 0.5, "works": 0.5}, behaviours={"sloppy": 1.0}
    )
    return msgspec.structs.replace(split, drives=recipe)


VAL = short(load_split("val"))


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two short drives, made by two workers."""
    root = tmp_path_factory.mktemp("drives") / "two"
    render_split(VAL, root, kind="drives", count=2, size_px=SIZE, workers=2)
    return root


@pytest.fixture(scope="module")
def drives(root: Path) -> DriveDataset:
    return DriveDataset(root)


def test_a_drives_bytes_are_the_same_wherever_it_is_made(root: Path) -> None:
    plan = plan_dataset(VAL, 2, SIZE, kind="drives")
    for number in (1, 0):
        data, frames = render_drive(ShardTask(out=str(root), number=number, plan=plan, salt=None))
        assert data == (root / f"shard-{number:05d}.h5").read_bytes() and frames > 60


def test_pictures_come_at_the_cameras_own_periods_and_show_where_the_robot_was(drives: DriveDataset) -> None:
    for k in range(len(drives)):
        log = drives.drive(k)
        end_s = log.truth["time_s"][-1]
        for camera, period_s in (("road", 0.05), ("panel", 0.2)):
            pictures = drives.pictures(k, camera)
            np.testing.assert_allclose(pictures.time_s, np.arange(int(end_s / period_s + 1e-6) + 1) * period_s)
            np.testing.assert_array_equal(pictures.arrival_time_s, pictures.time_s)
            mount = drives.scenario(k).rig.camera(camera)
            truth = drives.scenario(k).robot_truth
            for time_s, i in zip(pictures.time_s[::7], pictures.frame[::7], strict=True):
                assert drives.frames.camera(i) == camera
                row = round(time_s / 0.05)
                robot = Pose3.from_figures(log.truth["pose_world_robot"][row])
                wanted = robot @ mount.pose_robot_camera(truth.camera_pitch_rad, truth.camera_roll_rad)
                np.testing.assert_allclose(drives.frames.pose_world_camera(i), wanted.matrix(), atol=1e-6)


def test_pictures_are_those_that_a_submission_would_get(drives: DriveDataset) -> None:
    """Taken one after the other by the renderer of driving, with no labels between."""
    scenario, plan = draw_drive(VAL, 0, SensorRig(cameras=drives.frames.manifest.cameras))
    renderer = plan_renderer(drives.frames.manifest)
    renderer.load(scenario)
    rows = [row for row in simulate(scenario, plan).rows if row.step < 24]
    wanted = []
    for row in rows:
        renderer.set_panel(row.sign)
        renderer.place(row.bodies, row.torn)
        for mount in renderer.rig.cameras:
            if row.step % mount.period_steps == 0:
                pose = row.pose_world_robot
                wanted.append(renderer.picture(mount.name, pose, time_s=row.time_s, motion=row.motion))
    assert [drives.frames.jpeg(i) for i in range(len(wanted))] == wanted


def test_a_late_camera_delivers_only_what_arrives_in_time(root: Path, tmp_path: Path) -> None:
    plan = plan_dataset(VAL, 1, SIZE, kind="drives")
    late = tuple(msgspec.structs.replace(mount, latency_s=0.12) for mount in plan.cameras)
    task = ShardTask(out="", number=0, plan=msgspec.structs.replace(plan, cameras=late), salt=None)
    data, frames = render_drive(task)
    (tmp_path / "late.h5").write_bytes(data)
    with h5py.File(tmp_path / "late.h5") as file:
        times, arrivals = file["pictures/time_s"][:], file["pictures/arrival_time_s"][:]
        end_s = file["truth/time_s"][-1]
    np.testing.assert_allclose(arrivals - times, 0.12)
    assert arrivals.max() <= end_s < arrivals.max() + 0.05 and len(times) == frames


def test_pictures_are_labelled(drives: DriveDataset) -> None:
    found = {label.category_id for i in range(0, len(drives.frames), 5) for label in drives.frames.annotations(i)}
    assert found & {CATEGORY_ID["box"], CATEGORY_ID["cone"]}
    shown = {label.category_id for i in range(len(drives.frames)) for label in drives.frames.annotations(i)}
    assert CATEGORY_ID["crosswalk"] in shown or len(shown) > 1
    assert drives.frames.picture(0).shape == (120, 160, 3)
    assert drives.frames.conditions(0).scenario == drives.scenario(0).name == "val-drive-00000"


def test_tum_files_hold_the_truth(root: Path, drives: DriveDataset) -> None:
    for k in range(len(drives)):
        rows = np.loadtxt(root / "poses" / f"drive-{k:05d}.tum")
        truth = drives.drive(k).truth
        np.testing.assert_allclose(rows[:, 0], truth["time_s"], atol=1e-6)
        np.testing.assert_allclose(rows[:, 1:], truth["pose_world_robot"], atol=1e-8)


def test_a_log_says_who_drove_and_how(drives: DriveDataset) -> None:
    for k in range(len(drives)):
        log, scenario = drives.drive(k), drives.scenario(k)
        steps = len(log.truth["time_s"])
        assert len(log.command["v_mps"]) == len(log.panel["sign"]) == steps
        assert set(log.panel["sign"]) <= {b"stop", b"up"}
        assert log.script.seed == scenario.seed and log.script.ending == "time"
        assert scenario.robot_truth.wheel_radius_left_m != scenario.robot.wheel_radius_m
        np.testing.assert_allclose(
            log.truth["pose_world_robot"][0, :2], (log.script.start_pose.x_m, log.script.start_pose.y_m), atol=0.01
        )


def test_a_dataset_of_frames_is_no_dataset_of_drives(tmp_path: Path) -> None:
    render_split(load_split("val"), tmp_path / "frames", count=2, size_px=SIZE)
    with pytest.raises(InputError) as caught:
        DriveDataset(tmp_path / "frames")
    assert "a dataset of frames" in str(caught.value) and "--kind drives" in str(caught.value)


def test_a_damaged_log_is_told(root: Path, tmp_path: Path) -> None:
    copied = Path(shutil.copytree(root, tmp_path / "copy"))
    data = bytearray((copied / "shard-00001.h5").read_bytes())
    data[:512] = bytes(512)
    (copied / "shard-00001.h5").write_bytes(data)
    broken = DriveDataset(copied)
    assert broken.drive(0).script.number == 0
    with pytest.raises(InputError) as caught:
        broken.drive(1)
    assert "shard-00001.h5" in str(caught.value)


def test_frames_of_drives_read_like_any_others(root: Path) -> None:
    dataset = FrameDataset(root)
    assert len(dataset) == sum(entry.frames for entry in dataset.manifest.shards)
    assert {dataset.camera(i) for i in range(6)} == {"road", "panel"}


def test_the_pages_example_runs_and_names_every_column(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (Path(__file__).parents[1] / "docs" / "drives.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(root)
    found: dict = {}
    exec(code.replace('"DIR"', '"."'), found)
    true_m = np.hypot(np.diff(found["x_m"]), np.diff(found["y_m"])).sum()
    assert found["travelled_m"] == pytest.approx(true_m, rel=0.05) and found["rgb"].shape == (120, 160, 3)
    with h5py.File(root / "shard-00000.h5") as file:
        names = [column for group in GROUPS for column in (group, *file[group])]
    assert [name for name in names if f"`{name}`" not in page] == []


def test_a_preview_shows_a_drive_about_once_a_second(drives: DriveDataset) -> None:
    chosen = spread(drives.frames, 1000)
    assert all(b - a >= 24 for a, b in itertools.pairwise(chosen) if drives.frames.file(a) == drives.frames.file(b))
