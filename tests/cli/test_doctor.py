"""Doctor on the machine that runs the tests, and with things taken away from it."""

import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from adc_bench.cli.doctor import Check


def run_doctor(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", "from adc_bench.cli.main import main; main()", "doctor", *words],
        capture_output=True,
        text=True,
        env=os.environ | environment,
        check=False,
    )


def test_this_machine_is_well() -> None:
    report = run_doctor("--json")
    checks = {check.name: check for check in msgspec.json.decode(report.stdout, type=list[Check])}
    assert report.returncode == 0, report.stdout
    assert all(check.ok for check in checks.values() if check.needed)
    assert "Mesa" in checks["driver"].found
    assert "first picture in" in checks["renderer"].found


def test_a_machine_without_a_driver_is_told_how_to_mend_it(tmp_path: Path) -> None:
    nothing = str(tmp_path / "no_icd.json")
    report = run_doctor(VK_DRIVER_FILES=nothing, VK_ICD_FILENAMES=nothing)
    assert report.returncode == 4
    lines = report.stdout.splitlines()
    row = next(i for i, line in enumerate(lines) if line.startswith("MISSING  driver"))
    assert "no Vulkan device" in lines[row]
    assert lines[row + 1].strip().startswith("mend: make -C")
    assert lines[row + 1].endswith(" setup")


def test_a_broken_torch_is_reported(tmp_path: Path) -> None:
    (tmp_path / "torch.py").write_text("raise ImportError('libcudart.so: no such file')")
    report = run_doctor(PYTHONPATH=str(tmp_path))
    assert report.returncode == 4
    assert "MISSING  torch     ImportError: libcudart.so: no such file" in report.stdout


@pytest.mark.parametrize("ok", [True, False])
def test_a_check_survives_json(ok: bool) -> None:
    check = Check(name="gpu", found="none", ok=ok, needed=False)
    assert msgspec.json.decode(msgspec.json.encode(check), type=Check) == check
