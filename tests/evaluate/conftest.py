"""Submissions made of `agents.py`, a renderer for the whole room, a short suite, and a made leaderboard."""

import shutil
from pathlib import Path

import msgspec
import pytest
from made_board import make_poor_result, make_result
from made_runs import MakeSubmission

from adc_bench import leaderboard
from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.submission import Submission, load_submission
from adc_bench.evaluate.suite import Suite, load_suite
from adc_bench.render import ArenaRenderer

TEXT = """name = "{name}"
authors = ["someone"]
kind = "driver"
entry = "{module}:{factory}"
latency_s = {latency_s}
"""


@pytest.fixture
def submission_of(tmp_path: Path) -> MakeSubmission:
    def make(factory: str, *, module: str = "agents", latency_s: float = 0.0) -> Submission:
        folder = tmp_path / f"submission-{factory}"
        folder.mkdir()
        shutil.copy(Path(__file__).parent / "agents.py", folder)
        (folder / "broken.py").write_text("import nothing_of_this_name\n")
        (folder / "garbled.py").write_text("def make(:\n")
        name = factory.lower().replace("_", "-")
        text = TEXT.format(name=name, module=module, factory=factory, latency_s=latency_s)
        (folder / "submission.toml").write_text(text)
        return load_submission(str(folder), {})

    return make


@pytest.fixture(scope="session")
def renderer() -> ArenaRenderer:
    return ArenaRenderer(RULES.rig)


@pytest.fixture(scope="session")
def hurried() -> Rules:
    """The rules with budgets that a test can wait for."""
    return msgspec.structs.replace(RULES, limits=Limits(load_s=20.0, start_s=1.0, step_s=1.0))


@pytest.fixture(scope="session")
def short_suite() -> Suite:
    return msgspec.structs.replace(load_suite("dev"), start_delay_s=(0.3, 0.3), time_limit_s=1.0, seeds=(1, 2))


@pytest.fixture(scope="session")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Result folders on d1 by name: `quick`, `slow`, and `poor`, which hits a cone once and breaks once."""
    root = tmp_path_factory.mktemp("results")
    made = {name: make_result(root / name, name, half_laps) for name, half_laps in (("slow", 1), ("quick", 2))}
    return made | {"poor": make_poor_result(root / "poor", "poor")}


@pytest.fixture(scope="session")
def whole_board(tmp_path_factory: pytest.TempPathFactory, results: dict[str, Path]) -> Path:
    """A leaderboard of those results; to be changed in a copy only."""
    root = tmp_path_factory.mktemp("boards") / "board"
    for folder in results.values():
        leaderboard.add(folder, root)
    return root
