import hashlib
import json
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest
from made_answers import perfect_answers
from typer.testing import CliRunner

from adc_bench.cli.main import app
from adc_bench.dataset import FrameDataset
from adc_bench.detector.evaluation import EvaluatedWeights, Evaluation
from adc_bench.detector.model import build_network
from adc_bench.detector.note import ModelConfig
from adc_bench.detector.torch_backend import save_network
from adc_bench.errors import InputError
from adc_bench.world.categories import CATEGORIES

SCRIPT = Path(__file__).parents[2] / "scripts" / "model_card.py"
SMALL = ModelConfig(stem=16, widths=(24, 32, 48), depths=(0, 1, 0), neck=24, head=24)


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Those of a network that has learned nothing."""
    path = tmp_path_factory.mktemp("weights") / "small.safetensors"
    save_network(path, build_network(SMALL, len(CATEGORIES), seed=1))
    return path


def _run(*words: str | Path) -> str:
    result = CliRunner().invoke(app, ["evaluate", "detector", *(str(word) for word in words)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def test_the_command_says_what_it_evaluated_and_writes_equal_bytes(
    weights: Path, val_folder: Path, tmp_path: Path
) -> None:
    told = _run(weights, "--data", val_folder, "--out", tmp_path / "a.json")
    assert "mAP50-95" in told and "crosswalks found at 0.5-4 m, tunnel" in told and "light: dark" in told
    printed = _run(weights, "--data", val_folder, "--out", tmp_path / "b.json", "--page", tmp_path / "b.html", "--json")
    assert printed == (tmp_path / "a.json").read_text() == (tmp_path / "b.json").read_text()
    report = msgspec.json.decode(printed, type=EvaluatedWeights)
    assert report.weights_sha256 == hashlib.sha256(weights.read_bytes()).hexdigest()
    manifest = FrameDataset(val_folder).manifest
    assert (report.split, report.split_sha256) == ("val", manifest.split_sha256)
    assert report.shards_sha256 == manifest.shards_sha256 and len(report.shards_sha256) == 64
    assert "small.safetensors on the val split." in (tmp_path / "b.html").read_text()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "b.html", "b.json"]


def test_weights_or_pictures_that_are_not_there(weights: Path, val_folder: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        _run(tmp_path / "none.safetensors", "--data", val_folder, "--out", tmp_path / "a.json")
    with pytest.raises(InputError, match="an empty or missing folder"):
        _run(weights, "--data", tmp_path / "none", "--out", tmp_path / "a.json")
    assert not (tmp_path / "a.json").exists()


def _card(weights: Path, run: Path, report: Path, train: Path, val: Path) -> subprocess.CompletedProcess[str]:
    (run.parent / "small.toml").write_text("[train]\nepochs = 2\n")
    folders = ("--train", train, "--val", val, "--test", val)
    words = (weights, "--run", run, "--recipe", run.parent / "small.toml", *folders, "--report", report)
    command = [sys.executable, str(SCRIPT), *(str(word) for word in words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_card_has_the_report_s_figures_and_refuses_those_of_others(
    weights: Path, train_folder: Path, val_folder: Path, validation: FrameDataset, tmp_path: Path
) -> None:
    run, report = tmp_path / "run", tmp_path / "report.json"
    run.mkdir()
    (run / "log.jsonl").write_text("{}\n{}\n")
    (run / "metrics.json").write_bytes(
        msgspec.json.encode(Evaluation(validation, perfect_answers(validation)).report())
    )
    own = tmp_path / "n.safetensors"
    own.write_bytes(weights.read_bytes())
    content = json.loads(_run(own, "--data", val_folder, "--out", report, "--json"))
    done = _card(own, run, report, train_folder, val_folder)
    assert done.returncode == 0, done.stderr
    card = (tmp_path / "n.md").read_text()
    assert f"| mAP50-95 | {content['overall']['map']:.3f} |" in card and "best of 2 epochs" in card
    assert content["weights_sha256"] in card and f"| {content['split_sha256']}" not in card
    assert card.count(f"`{content['shards_sha256']}`") == 2  # of val, which is the test here
    assert "(1.000 there)" in card and str(tmp_path) not in card
    own.write_bytes(weights.read_bytes() + b" ")
    refused = _card(own, run, report, train_folder, val_folder)
    assert refused.returncode == 1 and "is the report of other weights or of other pictures" in refused.stderr
