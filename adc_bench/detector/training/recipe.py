"""A recipe: everything that decides what a training run makes of its pictures, read from TOML."""

from pathlib import Path

import msgspec

from adc_bench.detector.note import ModelConfig
from adc_bench.detector.training.augment import AugmentConfig
from adc_bench.detector.training.loss import LossConfig
from adc_bench.errors import InputError
from adc_bench.world.records import load_record

RECIPES = Path(__file__).parent / "recipes"


class TrainConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The course of a run.

    An epoch shows every picture with an object, and `empty_share` of those without, `batch` at a time (shared out
    between processes); the last `plain_epochs` are without mosaics. `learning_rate` rises over `warmup_steps` and falls
    to a hundredth along a cosine. Scored is the weights' running mean with `average_decay` a step, after every
    `validate_every` epochs and after the last; the best are kept, and the run ends early after `patience` scores
    without a better one. Its state is saved every `checkpoint_steps` and after every epoch. `threads` is part of it,
    for it decides the order of sums; `workers` (processes that change pictures) and `cache_bytes` (of pictures held in
    memory, in each process that changes them) decide nothing but time.
    """

    seed: int = 0
    epochs: int = 20
    plain_epochs: int = 2
    batch: int = 16
    validate_every: int = 4
    patience: int | None = None
    checkpoint_steps: int = 200
    empty_share: float = 0.3
    learning_rate: float = 2e-3
    weight_decay: float = 0.02
    warmup_steps: int = 60
    average_decay: float = 0.99
    gradient_norm_max: float = 10.0
    threads: int = 2
    workers: int = 0
    cache_bytes: int = 2**30


class Recipe(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Training, network, loss and augmentation."""

    train: TrainConfig = TrainConfig()
    model: ModelConfig = ModelConfig()
    loss: LossConfig = LossConfig()
    augment: AugmentConfig = AugmentConfig()


def load_recipe(name_or_path: str, *, epochs: int | None = None) -> Recipe:
    """Return the recipe of one of our names or of a TOML file's path (with a slash or ending in .toml), with another
    number of epochs if one is given.

    Raises:
        InputError: no such recipe or file, not TOML, an unknown key or a value of the wrong type.
    """
    is_path = "/" in name_or_path or name_or_path.endswith(".toml")
    if not is_path and name_or_path not in known_recipes():
        raise InputError(
            where=f"recipe {name_or_path!r}",
            found="an unknown name",
            wanted=f"one of {', '.join(known_recipes())}, or the path of a TOML file",
            todo="choose one of these, or write a file with what is to differ",
        )
    recipe = load_record(Path(name_or_path) if is_path else RECIPES / f"{name_or_path}.toml", Recipe)
    if epochs is not None:
        recipe = msgspec.structs.replace(recipe, train=msgspec.structs.replace(recipe.train, epochs=epochs))
    return recipe


def known_recipes() -> list[str]:
    """Return the names of our recipes, in order."""
    return sorted(path.stem for path in RECIPES.glob("*.toml"))
