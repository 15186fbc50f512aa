"""Folders of submissions made of `hostile.py`."""

import shutil
from pathlib import Path

from adc_bench.evaluate.submission import Submission, load_submission

TOML = 'name = "hostile"\nauthors = ["someone"]\nkind = "driver"\nentry = "hostile:{}"\n'


def hostile_submission(folder: Path, factory: str, target: Path = Path("/nowhere")) -> Submission:
    """Make a folder whose submission is one of `hostile.py`, and harms `target`."""
    folder.mkdir()
    shutil.copy(Path(__file__).parent / "hostile.py", folder)
    (folder / "target.txt").write_text(str(target))
    (folder / "submission.toml").write_text(TOML.format(factory))
    return load_submission(str(folder), {})
