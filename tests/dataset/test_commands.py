import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import pytest
from typer.testing import CliRunner

from adc_bench.cli.main import app
from adc_bench.errors import InputError, UsageError

RENDER = ["render", "--split", "val", "--size", "96x72"]


def _run(*words: str | Path) -> str:
    result = CliRunner().invoke(app, [str(word) for word in words], catch_exceptions=False)
    assert result.exit_code == 0
    return result.stdout


def test_render_check_preview(tmp_path: Path) -> None:
    out = tmp_path / "val"
    told = _run(*RENDER, "--frames", "40", "--workers", "1", "--out", out)
    assert "40 frames of 2 scenarios" in told and "panel 20, road 20" in told and "dark 32, dim 8" in told
    assert json.loads(_run(*RENDER, "--frames", "40", "--out", out, "--json"))["frames"] == 40
    assert "40 frames and" in _run("dataset", "check", out)
    assert json.loads(_run("dataset", "check", out, "--json"))["problems"] == []
    _run("dataset", "preview", out, "--out", tmp_path / "sheet.png")
    assert cv2.imread(str(tmp_path / "sheet.png")).shape == (5 * 72, 6 * 96, 3)


@pytest.mark.parametrize("size", ["320", "320x", "axb", "-3x5", "8x8", "9999x9999"])
def test_sizes_that_are_none(tmp_path: Path, size: str) -> None:
    with pytest.raises(UsageError, match="WIDTHxHEIGHT"):
        _run("render", "--split", "val", "--out", tmp_path / "a", "--size", size)


def test_a_place_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("a file")
    with pytest.raises(InputError, match="a file where a folder should be"):
        _run(*RENDER, "--frames", "2", "--out", tmp_path / "file")
    with pytest.raises(InputError, match="a folder to write to"):
        _run(*RENDER, "--frames", "2", "--out", tmp_path / "file" / "below")


def test_check_counts_the_problems(folder: Path) -> None:
    shard = folder / "shard-00000.h5"
    data = bytearray(shard.read_bytes())
    data[-1] ^= 0xFF
    shard.write_bytes(data)
    with pytest.raises(InputError, match="other bytes than were written"):
        _run("dataset", "check", folder)


def test_ctrl_c_leaves_nothing_half_written(tmp_path: Path) -> None:
    command = "from adc_bench.cli.main import main; main()"
    words = [*RENDER, "--frames", "256", "--frames-per-shard", "32", "--workers", "2", "--out", str(tmp_path / "a")]
    process = subprocess.Popen([sys.executable, "-c", command, *words], stderr=subprocess.PIPE, start_new_session=True)
    while not list(tmp_path.glob("a/shard-*.h5")):
        assert process.poll() is None
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    told = process.communicate(timeout=10)[1]
    assert process.returncode == 130 and told == b""
    assert not list(tmp_path.rglob("*.tmp")) and not list(tmp_path.rglob("*.json"))
