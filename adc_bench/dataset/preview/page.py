"""A page of pictures with their labels over them that needs nothing beside itself, no folder and no net."""

from collections.abc import Iterable
from html import escape

from adc_bench.dataset.preview.choose import spread
from adc_bench.dataset.preview.overlay import overlay
from adc_bench.dataset.read import FrameDataset
from adc_bench.pages import data_url, filled
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.look import LIGHT_LEVELS

FRAMES = 60


def page_of(dataset: FrameDataset, frames: int = FRAMES) -> bytes:
    """Return the HTML with up to so many pictures, chosen by `spread`; equal datasets give equal bytes.

    Raises:
        InputError: a shard cannot be read.
    """
    chosen = spread(dataset, frames)
    found = sorted({label.category_id for i in chosen for label in dataset.annotations(i)})
    split = dataset.manifest.split
    return filled(
        "adc_bench.dataset.preview",
        f"adc-bench dataset: {split.name}",
        shown=str(len(chosen)),
        total=f"{len(dataset):,}",
        size=f"{dataset.width_px} / {dataset.height_px}",
        levels=_options(level for level in LIGHT_LEVELS if level in split.looks.light_levels),
        cameras=_options(mount.name for mount in dataset.manifest.cameras),
        layouts=_options(sorted({dataset.scenario(i).layout.name for i in chosen})),
        categories=_options(CATEGORIES[k - 1] for k in found),
        figures="\n".join(_figure(dataset, i) for i in chosen),
    )


def _options(names: Iterable[str]) -> str:
    return "".join(f"<option>{escape(name)}</option>" for name in names)


def _figure(dataset: FrameDataset, i: int) -> str:
    """Return a picture as delivered, its overlay, and what it was taken under."""
    conditions, labels, layout = dataset.conditions(i), dataset.annotations(i), dataset.scenario(i).layout.name
    names = sorted({CATEGORIES[label.category_id - 1] for label in labels if not label.ignore})
    tunnel = "in" if conditions.in_tunnel else "out"
    told = (
        f"{dataset.camera(i)}, {conditions.light_level} ({conditions.illuminance_lux:.0f} lux), {layout}"
        f"{', in the tunnel' if conditions.in_tunnel else ''}"
    )
    kind = "jpeg" if dataset.jpeg(i).startswith(b"\xff\xd8") else "png"
    return (
        f'<figure tabindex="0" data-level="{conditions.light_level}" data-camera="{escape(dataset.camera(i))}" '
        f'data-tunnel="{tunnel}" data-layout="{escape(layout)}" data-categories="{" ".join(names)}">'
        f'<div class="picture"><img alt="frame {i}: {escape(", ".join(names) or "nothing labelled")}" '
        f'src="{data_url(dataset.jpeg(i), kind)}">'
        f"{overlay(labels, dataset.lane_lines(i), (dataset.width_px, dataset.height_px))}</div>"
        f"<figcaption><b>{i}</b> {escape(told)}</figcaption></figure>"
    )
