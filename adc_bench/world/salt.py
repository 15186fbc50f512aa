"""A private salt: seeds that none can know without it, and a digest that names the salt without telling it."""

import hashlib
import hmac
import os
from collections.abc import Mapping
from pathlib import Path

from adc_bench.errors import InputError

VARIABLE = "ADC_BENCH_SALT"
SHORTEST_BYTES = 16


def load_salt(file: Path | None, environment: Mapping[str, str] = os.environ) -> bytes | None:
    """Return the salt that a file holds, or else the environment's ADC_BENCH_SALT; None if there is neither.

    White space at the ends does not count.

    Raises:
        InputError: the file cannot be read, or the salt is shorter than 16 bytes: it could be guessed.
    """
    where = f"--salt-file {file}" if file else VARIABLE
    try:
        text = file.read_bytes() if file else environment.get(VARIABLE, "").encode()
    except OSError as error:
        raise _unusable(where, error.strerror or "an unreadable file") from None
    salt = text.strip()
    if not salt and not file:
        return None
    if len(salt) < SHORTEST_BYTES:
        raise _unusable(where, f"{len(salt)} bytes")
    return salt


def salt_sha256(salt: bytes) -> str:
    """Return the digest by which a salt is known in public."""
    return hashlib.sha256(b"adc-bench salt\0" + salt).hexdigest()


def salted_seed(salt: bytes, name: str, number: int) -> int:
    """Return a seed of 63 bits: HMAC-SHA256 of name and number under the salt."""
    digest = hmac.digest(salt, f"{name}/{number}".encode(), "sha256")
    return int.from_bytes(digest[:8], "little") >> 1


def _unusable(where: str, found: str) -> InputError:
    return InputError(
        where=where,
        found=found,
        wanted=f"a secret of at least {SHORTEST_BYTES} bytes",
        todo="make one, for instance: openssl rand -hex 32 >salt.txt",
    )
