"""A recipe: everything that decides what a training run makes of its pictures, read from TOML."""

from pathlib import Path

import msgspec

from adc_bench.detector.augment import AugmentConfig
from adc_bench.detector.loss import LossConfig
from adc_bench.detector.note import ModelConfig
from adc_bench.world.records import load_record

RECIPES = Path(__file__).parent / "recipes"


class TrainConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The course of a run.

    An epoch shows every picture with an object, and `empty_share` of those without. `learning_rate` rises over
    `warmup_steps` and falls to a hundredth along a cosine. Scored is the weights' running mean with `average_decay` a
    step, after every `validate_every` epochs and after the last; the best are kept. `threads` is part of it, for it
    decides the order of sums.
    """

    seed: int = 0
    epochs: int = 20
    batch: int = 8
    validate_every: int = 4
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


def load_recipe(path: Path, *, epochs: int | None = None) -> Recipe:
    """Return the recipe of a TOML file, with another number of epochs if one is given.

    Raises:
        InputError: no such file, not TOML, an unknown key or a value of the wrong type.
    """
    recipe = load_record(path, Recipe)
    if epochs is not None:
        recipe = msgspec.structs.replace(recipe, train=msgspec.structs.replace(recipe.train, epochs=epochs))
    return recipe
