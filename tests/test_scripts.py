"""The scripts: shell that parses everywhere, and the demo's summary."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[1] / "scripts"


@pytest.mark.parametrize("script", sorted(SCRIPTS.glob("*.sh")), ids=lambda path: path.name)
def test_every_script_is_plain_shell(script: Path) -> None:
    assert script.read_text(encoding="utf-8").startswith("#!/bin/sh\n")
    subprocess.run(["sh", "-n", str(script)], check=True)


def demo_folder(root: Path, *completion: float) -> Path:
    coco = {"images": [{}, {}], "annotations": [{}]}
    episodes = [{"completion": share, "reason": "finished" if share == 1.0 else "off-road"} for share in completion]
    means = {
        "driving_score": 95.0,
        "lap_time_s": 41.25,
        "position_rmse_m": 0.0561,
        "dead_reckoning_rmse_m": 0.25,
        "line_touches": 1.5,
        "collisions": 0.0,
    }
    summary = {name: {"mean": mean} for name, mean in means.items()}
    score = {"pictures": 2, "map50": 0.9, "categories": {"crosswalk": {"ap50": 0.95, "objects": 7}}}
    result = {"suite": "d1", "submission": {"name": "thesis"}, "episodes": episodes, "summary": summary}
    texts = {
        "train/annotations/instances.json": json.dumps(coco),
        "val/annotations/instances.json": json.dumps(coco),
        "detector/weights.safetensors": "x" * 2000,
        "detector/predictions.png": "x",
        "detector/metrics.json": json.dumps({"overall": score}),
        "drive/result.json": json.dumps(result),
        "drive/paths.png": "x",
        "leaderboard.json": "{}",
        "site/index.html": "x",
    }
    for name, text in texts.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    return root


def summarise(folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(SCRIPTS / "demo_summary.py"), folder.name, "432"]
    return subprocess.run(command, cwd=folder.parent, capture_output=True, text=True, check=False)


def test_the_summary_names_files_score_and_time(tmp_path: Path) -> None:
    done = summarise(demo_folder(tmp_path / "demo", 1.0, 0.4))
    assert done.returncode == 0, done.stderr
    assert "  demo/train/: 2 pictures, 1 boxes\n" in done.stdout
    assert "  demo/detector/weights.safetensors: 2 kB\n" in done.stdout
    assert (
        "  drives of two laps that came to their end: 1 of 2\n  score: 95.0 of 100\n  lap time: 41.2 s\n" in done.stdout
    )
    assert "  position RMSE: 0.056 m (dead reckoning: 0.250 m)\n  line touches a drive: 1.5\n" in done.stdout
    assert "  mAP50 0.900 on 2 validation pictures\n  crosswalk: AP50 0.950 of 7\n" in done.stdout
    assert "  7 min 12 s\n" in done.stdout


def test_a_demo_without_a_whole_drive_fails(tmp_path: Path) -> None:
    done = summarise(demo_folder(tmp_path / "demo", 0.4, 0.0))
    assert done.returncode == 1
    assert done.stderr == "error: not one drive came to its end: off-road\n"


@pytest.mark.parametrize(
    ("uid", "apt_exits", "told"),
    [
        (0, 0, "apt-get install -q -y --no-install-recommends chromium\n"),
        (0, 100, "chromium cannot be installed: tests of pages will be skipped\n"),
        (1000, 0, "no chromium: tests of pages will be skipped (as root: "),
    ],
)
def test_the_browser_is_installed_where_it_can_be(tmp_path: Path, uid: int, apt_exits: int, told: str) -> None:
    """A PATH with nothing but what the script calls, and an apt-get that only says what it is asked."""
    if not Path("/etc/debian_version").exists() or "ID=debian" not in Path("/etc/os-release").read_text().split("\n"):
        pytest.skip("only Debian's chromium is installed")
    for name in ("sh", "grep"):
        (tmp_path / name).symlink_to(str(shutil.which(name)))
    fakes = {"id": f"echo {uid}", "apt-get": f'echo "apt-get $*"\nexit {apt_exits}'}
    for name, body in fakes.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / name).chmod(0o755)
    command = ["sh", str(SCRIPTS / "system_packages.sh"), "browser"]
    done = subprocess.run(command, env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stderr == "" and told in done.stdout


@pytest.mark.parametrize(
    ("uid", "apt_exits", "told"),
    [
        (0, 0, "apt-get install -q -y --no-install-recommends g++\n"),
        (0, 100, "g++ cannot be installed: tests of the C++ example will be skipped\n"),
        (1000, 0, "no g++: tests of the C++ example will be skipped (as root: "),
    ],
)
def test_the_compiler_is_installed_where_it_can_be(tmp_path: Path, uid: int, apt_exits: int, told: str) -> None:
    for name in ("sh", "grep"):
        (tmp_path / name).symlink_to(str(shutil.which(name)))
    fakes = {"id": f"echo {uid}", "apt-get": f'echo "apt-get $*"\nexit {apt_exits}'}
    for name, body in fakes.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / name).chmod(0o755)
    command = ["sh", str(SCRIPTS / "system_packages.sh"), "compiler"]
    done = subprocess.run(command, env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stderr == "" and told in done.stdout
