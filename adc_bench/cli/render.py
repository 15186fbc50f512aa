"""`adc-bench render`: a labelled dataset of a split."""

import json
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from adc_bench.cli.progress import progress_bar
from adc_bench.errors import UsageError
from adc_bench.world.quality import Extra, Quality

if TYPE_CHECKING:
    from adc_bench.dataset.layout import Summary
    from adc_bench.generate import Progress

Kind = Literal["frames", "drives"]
Engine = Literal["local", "ray"]


def render(
    split: Annotated[str, typer.Option(help="A split's name (splits/NAME.toml) or the path of its file.")],
    out: Annotated[
        str, typer.Option(help="The dataset's folder, or an address as s3://bucket/name; run again on it to resume.")
    ],
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
    engine: Annotated[
        Engine, typer.Option(help="Processes of this machine, or the Ray cluster that runs (RAY_ADDRESS).")
    ] = "local",
    workers: Annotated[
        int | None, typer.Option(min=1, help="Shards made at once; as many as there are processors if left out.")
    ] = None,
    frames_per_shard: Annotated[int, typer.Option(min=1, help="Frames in one file.")] = 256,
    salt_file: Annotated[
        Path | None, typer.Option(help="The secret of a salted split; or ADC_BENCH_SALT in the environment.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a dataset of another run.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Render and label the pictures of a split."""
    import msgspec

    from adc_bench.dataset.split import load_split

    size_px, chosen = parse_size(size), load_split(split)
    from adc_bench.generate import Progress, render_split
    from adc_bench.world.salt import load_salt

    salt = load_salt(salt_file)
    asked: tuple[tuple[Extra, bool], ...] = (("depth", depth), ("semantic", semantic))
    told: list[Progress] = []
    with progress_bar("rendering shards") as tell:

        def progress(now: Progress) -> None:
            told[:] = [now]
            tell(now.done, now.total, now.text)

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
            engine=engine,
            workers=workers,
            overwrite=overwrite,
            progress=progress,
        )
        elapsed_s = perf_counter() - start_s
    report = {**msgspec.to_builtins(summary), "out": out, "elapsed_s": round(elapsed_s, 3)}
    report["this_run"] = {"frames": told[0].frames, "nodes": msgspec.to_builtins(told[0].nodes)}
    typer.echo(json.dumps(report, indent=2) if as_json else "\n".join(_summary_lines(summary, told[0], out, elapsed_s)))


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


def _summary_lines(summary: "Summary", run: "Progress", out: str, elapsed_s: float) -> Iterator[str]:
    yield f"{out}: {summary.frames} frames of {summary.scenarios} scenarios, {summary.size_bytes / 1e6:.1f} MB"
    if summary.driving:
        driving = summary.driving
        yield f"  {driving.drives} drives, {driving.simulated_s:.0f} s simulated, {driving.distance_m:.0f} m"
    yield f"  {run.frames} of the frames made now, in {elapsed_s:.1f} s ({run.frames_per_s:.1f} frames/s)"
    for name in sorted(run.nodes):
        yield f"  {name}: {run.nodes[name]}"
    rows = {
        "cameras": summary.cameras,
        "light levels": {**summary.light_levels, "tunnel": summary.tunnel_frames},
        "boxes": {**summary.boxes, "ignored": summary.ignored},
    }
    for name, counts in rows.items():
        yield f"  {name + ':':<14}" + ", ".join(f"{key} {count}" for key, count in counts.items())
