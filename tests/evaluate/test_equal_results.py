"""A result is the same however it came about, and records that were harmed are errors."""

from pathlib import Path

import msgspec
import pytest
from made_runs import MakeSubmission

from adc_bench.errors import InputError, UsageError
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.run import evaluate_submission, rescore
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import Suite

CPP = Path(__file__).parents[2] / "examples" / "cpp_driver"


def scored(folder: Path) -> dict[str, bytes]:
    """Return the files that must not depend on how the runs were driven."""
    paths = [folder / "result.json", *folder.glob("episodes/*"), *folder.glob("failures/*/*")]
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(paths)}


@pytest.fixture(scope="session")
def tiny_suite(short_suite: Suite) -> Suite:
    return msgspec.structs.replace(short_suite, start_delay_s=(0.1, 0.1), time_limit_s=0.4)


def test_workers_and_in_process_give_equal_bytes(
    submission_of: MakeSubmission, tiny_suite: Suite, hurried: Rules, tmp_path: Path
) -> None:
    submission = submission_of("RaisesAtSeven")
    ways = {"plain": {}, "two": {"workers": 2}, "in-process": {"in_process": True}}
    for name, way in ways.items():
        result = evaluate_submission(submission, tiny_suite, tmp_path / name, rules=hurried, **way)
        assert (result.planned, result.completed) == (2, 2)
    plain = scored(tmp_path / "plain")
    assert scored(tmp_path / "two") == plain
    assert scored(tmp_path / "in-process") == plain
    assert [name for name in plain if name.startswith("failures/dev-1")] == [
        "failures/dev-1/observation.json",
        "failures/dev-1/road.jpg",
    ]
    timing = msgspec.json.decode((tmp_path / "in-process" / "timing.json").read_bytes())
    assert timing["isolation"] == "in-process"


def test_a_command_cannot_run_in_process(tiny_suite: Suite, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="a submission that is a command"):
        evaluate_submission(load_submission(str(CPP), {}), tiny_suite, tmp_path / "out", in_process=True)


def test_harmed_records_are_errors(
    submission_of: MakeSubmission, tiny_suite: Suite, hurried: Rules, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    evaluate_submission(submission_of("Still"), tiny_suite, out, in_process=True, rules=hurried)
    first, second = (out / "episodes" / f"{tiny_suite.scenario_name(seed)}.jsonl" for seed in tiny_suite.seeds)
    whole = first.read_bytes()
    for harmed, found in (
        (whole[:-20], "a damaged episode log"),
        (whole.replace(b'"v_mps":0.0', b'"v_mps":0.1', 1), "a damaged episode log: other lines than were written"),
        (whole.replace(b'"panel":"stop"', b'"panel":"up"', 1), "a damaged episode log"),
        (second.read_bytes(), "once more"),
        (b"", "a damaged episode log"),
    ):
        assert harmed != whole
        first.write_bytes(harmed)
        with pytest.raises(InputError) as caught:
            rescore(out, hurried)
        assert found in caught.value.found
    first.write_bytes(whole)
    (out / "episodes" / "mine.jsonl").write_bytes(whole)
    with pytest.raises(InputError, match="the log of none of the planned runs"):
        rescore(out, hurried)


def test_runs_of_two_versions_do_not_mix(
    submission_of: MakeSubmission, tiny_suite: Suite, hurried: Rules, tmp_path: Path
) -> None:
    outs = [tmp_path / name for name in ("one", "two")]
    for out, factory in zip(outs, ("Still", "Straight"), strict=True):
        evaluate_submission(submission_of(factory), tiny_suite, out, in_process=True, rules=hurried)
    name = f"{tiny_suite.scenario_name(tiny_suite.seeds[1])}.jsonl"
    (outs[0] / "episodes" / name).write_bytes((outs[1] / "episodes" / name).read_bytes())
    with pytest.raises(InputError) as caught:
        rescore(outs[0], hurried)
    assert caught.value.found.startswith("another run than that of")
    (outs[0] / "episodes" / name).unlink()
    result = rescore(outs[0], hurried)
    assert (result.status, result.eligible, result.completed) == ("aborted", False, 1)
