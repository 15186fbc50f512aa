"""`adc-bench render`: a labelled dataset of a split."""

import json
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any, Literal

import typer

from adc_bench.cli.progress import progress_bar
from adc_bench.errors import UsageError
from adc_bench.world.quality import Extra, Quality

Kind = Literal["frames", "drives"]


def render(
    split: Annotated[str, typer.Option(help="A split's name (splits/NAME.toml) or the path of its file.")],
    out: Annotated[Path, typer.Option(help="The dataset's folder; run again on it to resume.")],
    frames: Annotated[
        int | None, typer.Option(help="How many frames or drives; the split's own number if left out.")
    ] = None,
    kind: Annotated[Kind, typer.Option(help="Independent frames, or drives with all sensors.")] = "frames",
    size: Annotated[str, typer.Option(help="Picture size, WIDTHxHEIGHT in pixels.")] = "320x240",
    quality: Annotated[
        Quality, typer.Option(help="fast, or SAPIEN's own packs with shadows or traced paths (seconds a frame).")
    ] = "fast",
    depth: Annotated[bool, typer.Option("--depth", help="Keep each pixel's distance along the camera's axis.")] = False,
    semantic: Annotated[bool, typer.Option("--semantic", help="Keep each pixel's class.")] = False,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes; one per processor if left out.")] = None,
    frames_per_shard: Annotated[int, typer.Option(min=1, help="Frames in one file.")] = 256,
    salt_file: Annotated[
        Path | None, typer.Option(help="The secret of a salted split; or ADC_BENCH_SALT in the environment.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a dataset of another run.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Render and label the pictures of a split."""
    from adc_bench.dataset.split import load_split

    size_px, chosen = parse_size(size), load_split(split)
    from adc_bench.engine import default_workers
    from adc_bench.generate import render_split
    from adc_bench.world.salt import load_salt

    salt = load_salt(salt_file)
    asked: tuple[tuple[Extra, bool], ...] = (("depth", depth), ("semantic", semantic))
    with progress_bar("rendering shards") as tell:
        start_s = perf_counter()
        summary = render_split(
            chosen,
            out,
            kind=kind,
            count=frames,
            size_px=size_px,
            quality=quality,
            extras=tuple(name for name, wanted in asked if wanted),
            salt=salt,
            frames_per_shard=frames_per_shard,
            workers=workers or default_workers(),
            overwrite=overwrite,
            progress=tell,
        )
        elapsed_s = perf_counter() - start_s
    _print_summary(summary, out, elapsed_s, as_json)


def parse_size(text: str) -> tuple[int, int]:
    """Return (width, height) of a text like 640x480.

    Raises:
        UsageError: it is no such text, or a side lies outside 32..4096 pixels.
    """
    sides = text.lower().split("x")
    if len(sides) == 2 and all(side.isascii() and side.isdigit() for side in sides):
        width_px, height_px = int(sides[0]), int(sides[1])
        if min(width_px, height_px) >= 32 and max(width_px, height_px) <= 4096:
            return width_px, height_px
    raise UsageError(
        where="--size",
        found=repr(text),
        wanted="WIDTHxHEIGHT, each side 32 to 4096 pixels",
        todo="say, for instance, --size 640x480",
    )


def _print_summary(summary: Any, out: Path, elapsed_s: float, as_json: bool) -> None:
    import msgspec

    if as_json:
        report = {**msgspec.to_builtins(summary), "out": str(out), "elapsed_s": round(elapsed_s, 3)}
        typer.echo(json.dumps(report, indent=2))
        return
    rate = summary.frames / elapsed_s
    typer.echo(
        f"{out}: {summary.frames} frames of {summary.scenarios} scenarios, {summary.size_bytes / 1e6:.1f} MB, "
        f"{elapsed_s:.1f} s ({rate:.1f} frames/s, frames kept from an earlier run included)"
    )
    rows = {
        "cameras": summary.cameras,
        "light levels": {**summary.light_levels, "tunnel": summary.tunnel_frames},
        "boxes": {**summary.boxes, "ignored": summary.ignored},
    }
    for name, counts in rows.items():
        typer.echo(f"  {name + ':':<14}" + ", ".join(f"{key} {count}" for key, count in counts.items()))
