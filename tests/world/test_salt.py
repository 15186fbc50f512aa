"""The private salt: where it comes from, what is refused, and what follows from it."""

import hashlib
from pathlib import Path

import pytest

from adc_bench.errors import InputError
from adc_bench.world.salt import SHORTEST_BYTES, VARIABLE, load_salt, salt_sha256, salted_seed

SALT = b"0123456789abcdef0123456789abcdef"


def test_a_file_comes_before_the_environment_and_white_space_does_not_count(tmp_path: Path) -> None:
    path = tmp_path / "salt.txt"
    path.write_bytes(b"  " + SALT + b"\n")
    other = {VARIABLE: "another secret, long enough"}
    assert load_salt(path, other) == SALT
    assert load_salt(None, other) == b"another secret, long enough"
    assert load_salt(None, {VARIABLE: f" {SALT.decode()}\n"}) == SALT
    assert load_salt(None, {}) is None and load_salt(None, {VARIABLE: "  "}) is None


@pytest.mark.parametrize("text", [b"", b"   \n", b"x" * (SHORTEST_BYTES - 1), b" " * 40 + b"short"])
def test_a_salt_that_could_be_guessed_is_refused(tmp_path: Path, text: bytes) -> None:
    path = tmp_path / "salt.txt"
    path.write_bytes(text)
    with pytest.raises(InputError, match="at least 16 bytes") as caught:
        load_salt(path, {})
    assert caught.value.exit_code == 3 and str(path) in caught.value.where
    assert f"{len(text.strip())} bytes" in str(caught.value)


def test_a_short_salt_in_the_environment_is_refused_and_not_told() -> None:
    with pytest.raises(InputError) as caught:
        load_salt(None, {VARIABLE: "hunter2"})
    assert caught.value.where == VARIABLE and "hunter2" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No such file"):
        load_salt(tmp_path / "nowhere.txt", {VARIABLE: SALT.decode()})


def test_the_digest_names_the_salt_and_is_not_its_plain_hash() -> None:
    assert salt_sha256(SALT) == salt_sha256(SALT) != salt_sha256(SALT + b"0")
    assert salt_sha256(SALT) != hashlib.sha256(SALT).hexdigest()
    assert salt_sha256(SALT) != salted_seed(SALT, "hidden", 0).to_bytes(8, "little").hex()


def test_seeds_follow_from_salt_name_and_number_and_spread_over_63_bits() -> None:
    seeds = [salted_seed(SALT, "hidden", k) for k in range(2000)]
    assert seeds == [salted_seed(SALT, "hidden", k) for k in range(2000)] and len(set(seeds)) == 2000
    assert all(0 <= seed < 2**63 for seed in seeds)
    ones = [sum(seed >> bit & 1 for seed in seeds) for bit in range(63)]
    assert all(850 < count < 1150 for count in ones)  # six and a half standard deviations
    assert not set(seeds) & {salted_seed(SALT + b"1", "hidden", k) for k in range(2000)}
    assert not set(seeds) & {salted_seed(SALT, "hidden2", k) for k in range(2000)}
