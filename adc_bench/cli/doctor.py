"""`adc-bench doctor`: what this machine offers, what it lacks, and the command that mends it."""

import json
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Annotated

import msgspec
import typer

from adc_bench.cli.vulkan import vulkan_devices
from adc_bench.errors import MachineError

PACKAGES = ("adc-bench", "sapien", "torch", "torchvision", "numpy", "opencv-python-headless", "h5py", "pycocotools")
TORCH_PROBE = "import torch, torchvision; print(torch.cuda.device_count())"
GIB = 2**30
MEMORY_WANTED_GIB = 3.0
PROBE_LIMIT_S = 120.0


class Check(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One thing looked at. `mend` is the command that puts it right, empty if nothing is wrong."""

    name: str
    found: str
    ok: bool
    needed: bool = True
    mend: str = ""


def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Say what renderer and driver are in use, what is missing, and the command that mends it."""
    checks = examine()
    if as_json:
        typer.echo(msgspec.json.format(msgspec.json.encode(checks), indent=2).decode())
    else:
        for check in checks:
            typer.echo(_line(check))
    if not all(check.ok for check in checks if check.needed):
        raise typer.Exit(MachineError.exit_code)


def examine() -> tuple[Check, ...]:
    """Return every check; takes a few seconds, since it draws a picture and loads torch."""
    return (_machine(), _memory(), _packages(), _driver(), _renderer(), _torch(), _gpu(), _sandbox())


def _line(check: Check) -> str:
    mark = "ok" if check.ok else "MISSING" if check.needed else "-"
    line = f"{mark:<8} {check.name:<9} {check.found}"
    return f"{line}\n{'':<18} mend: {check.mend}" if check.mend else line


def _machine() -> Check:
    cores = len(os.sched_getaffinity(0))
    return Check(name="machine", found=f"{_system_name()}, {platform.machine()}, {cores} cores", ok=True)


def _system_name() -> str:
    try:
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    except OSError:
        return platform.system()


def _memory() -> Check:
    total, free = (os.sysconf("SC_PAGE_SIZE") * os.sysconf(name) / GIB for name in ("SC_PHYS_PAGES", "SC_AVPHYS_PAGES"))
    enough = total >= MEMORY_WANTED_GIB
    mend = "" if enough else f"a machine with {MEMORY_WANTED_GIB:g} GiB, or fewer --workers"
    return Check(name="memory", found=f"{total:.1f} GiB, {free:.1f} unused", ok=enough, mend=mend)


def _packages() -> Check:
    found, absent = [f"Python {platform.python_version()}"], []
    for name in PACKAGES:
        try:
            found.append(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            absent.append(name)
    text = ", ".join(found) + (f"; not installed: {', '.join(absent)}" if absent else "")
    return Check(name="packages", found=text, ok=not absent, mend=_set_up(*absent) if absent else "")


def _driver() -> Check:
    devices = vulkan_devices()
    if devices is None:
        return Check(name="driver", found="no Vulkan loader (libvulkan.so.1)", ok=False, mend=_install_driver())
    software = [device for device in devices if device.type == "software"]
    text = "; ".join(f"{device.driver} ({device.type})" for device in devices) or "no Vulkan device"
    return Check(name="driver", found=text, ok=bool(software), mend="" if software else _install_driver())


def _renderer() -> Check:
    probe = _python("-m", "adc_bench.render.probe")
    if probe.returncode:
        text = f"no picture: {_last_line(probe.stderr) or f'exit status {probe.returncode}'}"
        return Check(name="renderer", found=text, ok=False, mend=_install_driver())
    drawn = json.loads(_last_line(probe.stdout))
    return Check(name="renderer", found=f"{drawn['device']}, first picture in {drawn['first_picture_s']} s", ok=True)


def _torch() -> Check:
    probe = _python("-c", TORCH_PROBE)
    if probe.returncode:
        return Check(name="torch", found=_last_line(probe.stderr), ok=False, mend=_set_up("torch", "torchvision"))
    gpus = int(_last_line(probe.stdout))
    return Check(name="torch", found=f"works, {f'{gpus} CUDA devices' if gpus else 'on the CPU'}", ok=True)


def _gpu() -> Check:
    query = ("nvidia-smi", "--query-gpu=name,memory.total", "--format=csv,noheader")
    gpus = _run(query).stdout.strip().replace("\n", "; ") if shutil.which(query[0]) else ""
    return Check(name="gpu", found=gpus or "none; nothing needs one", ok=bool(gpus), needed=False)


def _sandbox() -> Check:
    from adc_bench.evaluate.sandbox import sandbox_fault

    fault = sandbox_fault()
    if not fault:
        return Check(name="sandbox", found="bubblewrap works", ok=True, needed=False)
    found = f"{fault}; submissions run with limits only, and no leaderboard takes their results"
    return Check(name="sandbox", found=found, ok=False, needed=False, mend="apt-get install bubblewrap")


def _python(*arguments: str) -> subprocess.CompletedProcess[str]:
    return _run((sys.executable, *arguments))


def _run(command: Sequence[str]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=PROBE_LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, 1, "", f"no answer in {PROBE_LIMIT_S:g} s")


def _last_line(text: str) -> str:
    return text.strip().rpartition("\n")[2]


def _checkout() -> Path | None:
    root = Path(__file__).parents[2]
    return root if (root / "scripts" / "setup.sh").exists() else None


def _set_up(*packages: str) -> str:
    root = _checkout()
    if root:
        return f"rm -r {root}/.venv && make -C {root} setup"
    return f"{sys.executable} -m pip install {' '.join(packages)}"


def _install_driver() -> str:
    root = _checkout()
    if root:
        return f"make -C {root} setup"
    backports = "Debian GNU/Linux 12" in _system_name()
    suite = "-t bookworm-backports " if backports else ""
    return f"apt-get install {suite}mesa-vulkan-drivers libvulkan1 libx11-6" + (
        ", with bookworm-backports among the apt sources" if backports else ""
    )
