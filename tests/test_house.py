"""The repository speaks of itself alone: no registry's host, no machine's path, every locked package with hashes."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PATHS = re.compile(r"/(home/[a-z]|Users/[A-Z]|root/\.|work/|tmp/[a-z])")
HOSTS = re.compile(
    r"(pypi\.org|pythonhosted\.org|deb\.debian\.org|archive\.ubuntu\.com|\bsimple/|--(extra-)?index-url [^ ])"
)
MAY_NAME_THEM = {"tests/test_house.py"}


def tracked_files() -> list[Path]:
    try:
        listing = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z"], capture_output=True, text=True, check=True)
    except (FileNotFoundError, subprocess.CalledProcessError):
        pytest.skip("not a git checkout")
    return [ROOT / name for name in listing.stdout.split("\0") if name and name not in MAY_NAME_THEM]


def texts() -> list[tuple[str, str]]:
    files = [path for path in tracked_files() if path.is_file()]
    found = [(str(path.relative_to(ROOT)), path.read_bytes()) for path in files]
    return [(name, data.decode()) for name, data in found if b"\0" not in data and not name.endswith(".lock")]


@pytest.mark.parametrize("pattern", [PATHS, HOSTS], ids=["paths", "hosts"])
def test_no_text_names_a_machine(pattern: re.Pattern[str]) -> None:
    named = [f"{name}: {match.group()}" for name, text in texts() for match in pattern.finditer(text)]
    assert named == []


def test_every_locked_package_has_hashes_and_no_address() -> None:
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    entries = re.findall(r"^[a-z][^\n]*(?:\n +--hash=[^\n]*)*", text, re.MULTILINE)
    assert len(entries) > 50
    for entry in entries:
        head, *hashes = entry.splitlines()
        assert re.match(r"[a-z0-9_.-]+==[0-9][^ ]*( ; .*)? \\$", head), head
        assert hashes, head
        assert all(re.fullmatch(r" +--hash=sha256:[0-9a-f]{64}( \\)?", line) for line in hashes), head
    assert "://" not in text
    assert not re.search(r"^opencv-python==", text, re.MULTILINE)


def test_no_file_is_large() -> None:
    large = {str(path.relative_to(ROOT)): path.stat().st_size for path in tracked_files() if path.is_file()}
    assert {name: size for name, size in large.items() if size > 4_200_000} == {}
