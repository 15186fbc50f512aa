"""A hidden suite's file, made of an open one: the same trials under another name, drawn with a private salt."""

import re
from pathlib import Path

from adc_bench.dataset.layout import write_file
from adc_bench.errors import InputError
from adc_bench.evaluate.suite import load_suite
from adc_bench.world.records import find_record
from adc_bench.world.salt import salt_sha256

NAME = re.compile(r"[a-z0-9][a-z0-9_-]*\.toml")
KEY = re.compile(r"^name\s*=.*$", re.MULTILINE)
SPLIT = re.compile(r"^\[split\]$", re.MULTILINE)


def hide_suite(source: str, salt: bytes, out: Path) -> str:
    """Write the file of a suite that is hidden by a salt and named after its file; return the salt's digest.

    All but the name and the digest is as in the source; a suite of recordings also says that its split is salted.

    Raises:
        InputError: the source is no open suite, or the file's name is none for a suite, or the source's.
    """
    suite = load_suite(source)
    if suite.salt_sha256:
        raise _refused(f"suite {source}", "a hidden suite", "an open one", "name the suite that it was made of")
    if not NAME.fullmatch(out.name) or out.stem == suite.name:
        wanted = f"a name of its own for the hidden suite, such as {suite.name}-final.toml"
        raise _refused(f"--out {out}", f"the name {out.name!r}", wanted, "choose another name")
    digest = salt_sha256(salt)
    text = find_record(source, "splits/suites").read_text(encoding="utf-8")
    hidden = KEY.sub(f'name = "{out.stem}"\nsalt_sha256 = "{digest}"', text, count=1)
    write_file(out, SPLIT.sub("[split]\nsalted = true", hidden).encode())
    return digest


def _refused(where: str, found: str, wanted: str, todo: str) -> InputError:
    return InputError(where=where, found=found, wanted=wanted, todo=todo)
