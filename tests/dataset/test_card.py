"""The card says what the dataset holds and how it is made again, with a picture of it."""

import shlex
from pathlib import Path

import cv2
import msgspec
import pytest
from typer.testing import CliRunner

from adc_bench.cli.main import app
from adc_bench.dataset.card import card
from adc_bench.dataset.layout import DriveCounts, Manifest
from adc_bench.world.records import load_record


@pytest.fixture
def manifest(rendered: Path) -> Manifest:
    return load_record(rendered / "dataset.toml", Manifest)


def test_the_card_has_the_counts_and_a_picture(rendered: Path, manifest: Manifest) -> None:
    text = (rendered / "README.md").read_text()
    assert manifest.summary and f"| crosswalk | {manifest.summary.boxes['crosswalk']} |" in text
    assert "| pictures | 70 of 320x240 pixels |" in text and manifest.split_sha256 in text
    assert "(preview.jpg)" in text and cv2.imread(str(rendered / "preview.jpg")).shape == (480, 1280, 3)
    assert {name: (rendered / name).exists() for name in ("annotations/instances.json", "poses/road.tum")} == {
        "annotations/instances.json": True,
        "poses/road.tum": True,
    }
    assert max(map(len, text.split("\n"))) < 160


def test_its_command_makes_the_same_dataset(rendered: Path, manifest: Manifest, tmp_path: Path) -> None:
    """Run on the dataset itself it finds nothing to do; one of another number of pictures would be refused."""
    text = (rendered / "README.md").read_text()
    (line,) = [line for line in text.split("\n") if line.startswith("adc-bench render ")]
    words = shlex.split(line.replace("--out DIR", f"--out {rendered} --json"))[1:]
    before = {path: path.stat().st_mtime_ns for path in rendered.rglob("*")}
    run = CliRunner().invoke(app, words, catch_exceptions=False)
    assert run.exit_code == 0 and before == {path: path.stat().st_mtime_ns for path in rendered.rglob("*")}


def test_the_card_of_drives(manifest: Manifest) -> None:
    summary = msgspec.structs.replace(
        manifest.summary, driving=DriveCounts(drives=3, simulated_s=75.4, distance_m=60.2)
    )
    drives = msgspec.structs.replace(manifest, kind="drives", count=3, salt_sha256="ab" * 32)
    text = card(drives, summary)
    assert text.startswith("# adc-bench dataset: split `val`, drives\n\n3 drives of the ADC")
    assert "| driven | 3 drives, 75 s, 60 m |" in text and "poses/drive-*.tum" in text
    assert "--kind drives --frames 3 " in text and "--salt-file FILE" in text and "abab" in text
