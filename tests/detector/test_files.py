import json
from pathlib import Path
from typing import get_args

import msgspec
import pytest
import torch
from conftest import SMALL
from safetensors import safe_open
from safetensors.torch import save_file
from typer.testing import CliRunner

from adc_bench.cli.main import app
from adc_bench.detector import Detector
from adc_bench.detector.model import build_network
from adc_bench.detector.note import ARCHITECTURE, NOTE, ModelConfig, WeightsNote
from adc_bench.detector.predict import Runtime
from adc_bench.detector.torch_backend import load_network, save_network
from adc_bench.detector.training.device import choose_device
from adc_bench.detector.training.recipe import RECIPES, Recipe, known_recipes, load_recipe
from adc_bench.errors import AdcBenchError, InputError, MachineError
from adc_bench.world.categories import CATEGORIES


@pytest.fixture
def weights(tmp_path: Path) -> Path:
    save_network(tmp_path / "w.safetensors", build_network(SMALL, len(CATEGORIES), seed=1))
    return tmp_path / "w.safetensors"


def _note(**changes: object) -> dict[str, str]:
    note = msgspec.to_builtins(WeightsNote(architecture=ARCHITECTURE, config=SMALL, categories=CATEGORIES))
    return {NOTE: json.dumps({**note, **changes})}


def test_weights_come_back_as_they_went(weights: Path, tmp_path: Path) -> None:
    network = load_network(weights)
    written = build_network(SMALL, len(CATEGORIES), seed=1).state_dict()
    assert network.config == SMALL and not network.training
    assert all(torch.equal(value, written[name]) for name, value in network.state_dict().items())
    save_network(tmp_path / "again.safetensors", network)
    assert (tmp_path / "again.safetensors").read_bytes() == weights.read_bytes()
    assert not list(tmp_path.glob("*.part")) and not list(tmp_path.glob("*.tmp"))


def test_weights_say_what_they_are(weights: Path) -> None:
    with safe_open(weights, framework="pt") as content:
        note = json.loads(content.metadata()[NOTE])
    assert note["architecture"] == ARCHITECTURE and tuple(note["categories"]) == CATEGORIES
    assert note["config"]["widths"] == [24, 32, 48]


def test_the_default_network_fits_four_megabytes(tmp_path: Path) -> None:
    save_network(tmp_path / "w.safetensors", build_network(ModelConfig(), len(CATEGORIES)))
    assert (tmp_path / "w.safetensors").stat().st_size < 4e6


def _refused(path: Path, found: str) -> None:
    for runtime in get_args(Runtime):
        with pytest.raises(InputError) as caught:
            Detector.load(path, runtime=runtime)
        text = str(caught.value)
        assert (
            found in text and str(path) in text and f"architecture {ARCHITECTURE}" in text and "train-detector" in text
        )


def test_weights_that_cannot_be_used(weights: Path, tmp_path: Path) -> None:
    network = build_network(SMALL, len(CATEGORIES))
    tensors = {name: tensor.contiguous() for name, tensor in network.state_dict().items()}
    bad = tmp_path / "bad.safetensors"
    _refused(bad, "no such file")
    bad.write_bytes(b"\x80\x04 a pickle")
    _refused(bad, "not a whole safetensors file")
    bad.write_bytes(weights.read_bytes()[:-100])
    _refused(bad, "not a whole safetensors file")
    save_file(tensors, bad)
    _refused(bad, "without this project's note")
    save_file(tensors, bad, metadata=_note(architecture="resnet-50"))
    _refused(bad, "weights of architecture resnet-50")
    save_file(tensors, bad, metadata=_note(categories=["cat", "dog"]))
    _refused(bad, "weights for other categories: cat, dog")
    save_file(tensors, bad, metadata=_note(config={"widths": "wide"}))
    _refused(bad, "a note that cannot be read")
    save_file(tensors, bad, metadata=_note(config={"stem": 20}))
    _refused(bad, "tensors that do not fit the network")
    some = {name: tensor for name, tensor in tensors.items() if "heads.1" not in name}
    save_file(some, bad, metadata=_note())
    _refused(bad, "tensors that do not fit the network")
    save_file(
        tensors | {"backbone.stem.0.0.weight": tensors["backbone.stem.0.0.weight"] * torch.nan}, bad, metadata=_note()
    )
    _refused(bad, "weights that are not finite numbers")


@pytest.mark.parametrize("name", known_recipes())
def test_our_recipes_can_be_read(name: str) -> None:
    recipe = load_recipe(name)
    assert load_recipe(str(RECIPES / f"{name}.toml")) == recipe
    assert load_recipe(name, epochs=3).train.epochs == 3
    assert load_recipe(name, epochs=3).model == recipe.model
    assert (recipe.model == ModelConfig()) == (name != "s")


def test_an_unknown_recipe_is_told_with_those_that_are_known() -> None:
    with pytest.raises(InputError, match=r"recipe 'xl'\n.*an unknown name\n.*one of demo, n, s, or the path"):
        load_recipe("xl")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("[train]\nepoch = 3", "epoch"),
        ("[train]\nepochs = 'many'", "epochs"),
        ("[train", "TOML"),
        ("[model]\nwidths = [1, 2]", "widths"),
    ],
)
def test_recipes_that_cannot_be_read(tmp_path: Path, text: str, found: str) -> None:
    (tmp_path / "r.toml").write_text(text)
    with pytest.raises(InputError, match=found):
        load_recipe(str(tmp_path / "r.toml"))
    assert msgspec.structs.asdict(Recipe())


def _run(*words: str | Path) -> str:
    result = CliRunner().invoke(app, [str(word) for word in words], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def test_the_commands(train_folder: Path, val_folder: Path, tmp_path: Path) -> None:
    (tmp_path / "r.toml").write_text(
        "[train]\nbatch = 8\n[model]\nstem = 16\nwidths = [24, 32, 48]\ndepths = [0, 1, 0]"
    )
    run = tmp_path / "run"
    told = _run(
        "train-detector", "--train", train_folder, "--val", val_folder, "--out", run,
        "--config", tmp_path / "r.toml", "--epochs", "1", "--device", "cpu",
    )  # fmt: skip
    assert str(run / "weights.safetensors") in told and "crosswalk" in told and "mAP50-95" in told
    words = ("evaluate", "detector", run / "weights.safetensors", "--data", val_folder, "--out", tmp_path / "s.json")
    assert "light: dark" in _run(*words)
    report = json.loads(_run(*words, "--json"))
    assert report == json.loads((tmp_path / "s.json").read_text())
    assert report["overall"]["map"] == pytest.approx(
        json.loads((run / "metrics.json").read_text())["overall"]["map"], abs=0.01
    )
    with pytest.raises(InputError, match="a folder that holds files"):
        _run("train-detector", "--train", train_folder, "--val", val_folder, "--out", run)
    with pytest.raises(InputError, match="an empty or missing folder"):
        _run("train-detector", "--train", tmp_path / "none", "--val", val_folder, "--out", tmp_path / "other")


@pytest.mark.skipif(torch.cuda.is_available(), reason="has a GPU")
def test_a_gpu_that_is_not_there() -> None:
    assert choose_device("auto") == choose_device("cpu") == "cpu"
    with pytest.raises(MachineError, match="no GPU") as caught:
        choose_device("cuda")
    assert isinstance(caught.value, AdcBenchError)
