"""The walls around a submission's process: bubblewrap's namespaces, an unprivileged user, and limits.

Inside there is no network, no other process, and of the files only the system's programs, this Python with its
packages, the submission and what its options name, all read-only; /tmp and /dev/shm are its own, and small.
"""

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from adc_bench.evaluate.limits import Limits

PACKAGE = Path(__file__).parents[1]
# The names that a submission finds its things by inside.
SUBMISSION, LINK, TMP = Path("/submission"), Path("/run/adc-bench"), Path("/tmp")
TOP_LEVEL = ("bin", "sbin", "lib", "lib32", "lib64", "libx32")  # links into /usr, or folders of their own
SYSTEM_FILES = ("/etc/alternatives", "/etc/ld.so.cache", "/sys/devices/system/cpu")
# A user that no file and no other process belongs to: one for each sandbox that lives, so that the kernel's count of a
# user's processes is the sandbox's own.
FIRST_UID = 2_000_000_000
INNER_UID = "1000"
TRIAL_S = 20.0


@dataclass(frozen=True, kw_only=True)
class Room:
    """What a sandbox is made of: the submission's files (None: none), the folder of socket and pictures, files that
    options name, and the environment.
    """

    submission: Path | None
    link: Path
    files: Sequence[Path]
    environment: dict[str, str]


def in_sandbox(command: Sequence[str], room: Room, limits: Limits) -> list[str]:
    """Return the command line that runs a command inside."""
    is_root = os.geteuid() == 0
    return [
        "bwrap",
        *("--unshare-ipc", "--unshare-pid", "--unshare-net", "--unshare-uts", "--unshare-cgroup-try"),
        *("--die-with-parent", "--new-session", "--hostname", "adc-bench"),
        *_user_of_bwrap(is_root),
        *_files(room, limits),
        *("--clearenv", *(word for item in sorted(room.environment.items()) for word in ("--setenv", *item))),
        *("--chdir", str(SUBMISSION if room.submission else TMP), "--"),
        *(_drop(FIRST_UID + os.getpid()) if is_root else ()),
        *limited(command, limits, f"--nproc={limits.processes}"),
    ]


def limited(command: Sequence[str], limits: Limits, *more: str) -> list[str]:
    """Return the command line that runs a command under the limits that the kernel keeps for each process."""
    return [
        "prlimit",
        f"--data={limits.memory_bytes}",
        f"--cpu={round(limits.total_s)}",
        f"--fsize={limits.tmp_bytes}",
        f"--nofile={limits.open_files}",
        "--core=0",
        *more,
        *("--", *command),
    ]


@lru_cache(maxsize=1)
def sandbox_fault() -> str:
    """Return why no sandbox can be had on this machine; nothing if one can."""
    room = Room(submission=None, link=Path(__file__).parent, files=(), environment={})
    try:
        trial = subprocess.run(
            in_sandbox((sys.executable, "-c", "import encodings"), room, Limits()),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=TRIAL_S,
            check=False,
        )
    except FileNotFoundError:
        return "no bwrap on the PATH (package bubblewrap)"
    except subprocess.TimeoutExpired:
        return f"no answer from bwrap within {TRIAL_S:g} s"
    told = trial.stderr.strip().splitlines() or [f"exit status {trial.returncode}"]
    return told[-1] if trial.returncode else ""


def _user_of_bwrap(is_root: bool) -> Iterator[str]:
    """As root, files are bound whoever may enter their folders, and the command changes to another user then."""
    if is_root:
        for capability in ("CAP_SETUID", "CAP_SETGID", "CAP_SETPCAP"):
            yield from ("--cap-add", capability)
    else:
        yield from ("--unshare-user", "--uid", INNER_UID, "--gid", INNER_UID, "--disable-userns")


def _drop(uid: int) -> tuple[str, ...]:
    user = ("--reuid", str(uid), "--regid", str(uid), "--clear-groups")
    return ("setpriv", *user, "--bounding-set=-all", "--inh-caps=-all", "--no-new-privs", "--")


def _files(room: Room, limits: Limits) -> Iterator[str]:
    """In this order: what is bound later may lie inside of what was mounted before."""
    yield from _bound(Path("/usr"))
    for path in (Path("/", name) for name in TOP_LEVEL):
        if path.is_symlink():
            yield from ("--symlink", str(path.readlink()), str(path))
        elif path.is_dir():
            yield from _bound(path)
    for path in map(Path, SYSTEM_FILES):
        if path.exists():
            yield from _bound(path)
    yield from ("--proc", "/proc", "--dev", "/dev", *_own_tmpfs("/dev/shm", limits), "--remount-ro", "/dev")
    yield from _own_tmpfs(str(TMP), limits)
    for path in (*_python(), PACKAGE):
        yield from _bound(path)
    if (PACKAGE / "splits").is_dir():
        yield from ("--tmpfs", str(PACKAGE / "splits"))
    yield from _bound(room.link, LINK)
    if room.submission:
        yield from _bound(room.submission, SUBMISSION)
    for path in room.files:
        yield from _bound(path)
    yield from ("--remount-ro", "/")


def _bound(path: Path, inside: Path | None = None) -> Iterator[str]:
    """Bind a file or folder, the folders above it open to every user."""
    at = inside or path
    for folder in (*reversed(at.parents), *((at,) if path.is_dir() else ())):
        yield from ("--dir", str(folder))
    yield from ("--ro-bind", str(path), str(at))


def _own_tmpfs(path: str, limits: Limits) -> tuple[str, ...]:
    return ("--size", str(limits.tmp_bytes), "--perms", "1777", "--tmpfs", path)


def _python() -> list[Path]:
    """Return the folders of this Python that do not lie under /usr, outer ones only."""
    folders = {Path(prefix).resolve() for prefix in (sys.prefix, sys.base_prefix)} | {Path(sys.prefix)}
    return sorted(path for path in folders if not path.is_relative_to("/usr"))
