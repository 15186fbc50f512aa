"""`adc-bench dataset`: check a dataset, look at it."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from adc_bench.cli.progress import progress_bar
from adc_bench.errors import InputError, UsageError

if TYPE_CHECKING:
    from adc_bench.dataset.read import FrameDataset

app = typer.Typer(
    help="Check a dataset, look at it.", no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False
)
Folder = Annotated[str, typer.Argument(metavar="DIR", help="The dataset's folder or address.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the report as JSON.")]


@app.command()
def check(
    folder: Folder,
    against: Annotated[
        list[str] | None, typer.Option(metavar="DIR2", help="A dataset to share nothing with; may be given again.")
    ] = None,
    sample: Annotated[int, typer.Option(min=0, help="Of how many frames the labels are derived again.")] = 200,
    as_json: AsJson = False,
) -> None:
    """Read every picture, label and pose; exit 3 if anything is wrong."""
    import msgspec

    from adc_bench.dataset.check import Looked, find_problems
    from adc_bench.dataset.read import FrameDataset

    looked, problems = Looked(), []
    dataset, others = FrameDataset(folder), [FrameDataset(other) for other in against or ()]
    with progress_bar("checking shards") as tell:
        for problem in find_problems(dataset, others, sample=sample, looked=looked, progress=tell):
            problems.append(problem)
            if not as_json:
                typer.echo(problem)
    if as_json:
        typer.echo(json.dumps({**msgspec.to_builtins(looked), "problems": problems}, indent=2))
    if problems:
        raise InputError(
            where=folder,
            found=f"{len(problems)} problems, the first: {problems[0]}",
            wanted="a dataset as it was written",
            todo="copy it again, or render it again",
        )
    if not as_json:
        typer.echo(
            f"{folder}: {looked.frames} frames and {looked.labels} labels are in order "
            f"({looked.derived_again} labels of {min(sample, looked.frames)} frames derived again)"
        )


@app.command()
def stats(
    folder: Folder,
    out: Annotated[Path | None, typer.Option(metavar="DIR2", help="Write stats.png and stats.html there.")] = None,
    as_json: AsJson = False,
) -> None:
    """Count categories, sizes, distances, light, blur, arenas and drives."""
    import msgspec

    from adc_bench.dataset.layout import write_file
    from adc_bench.dataset.read import FrameDataset
    from adc_bench.dataset.stats import page_of, picture_of, statistics_of, text_of

    with progress_bar("reading shards") as tell:
        found = statistics_of(FrameDataset(folder), tell)
    if out:
        write_file(out / "stats.png", picture_of(found))
        write_file(out / "stats.html", page_of(found))
    typer.echo(json.dumps(msgspec.to_builtins(found), indent=2) if as_json else text_of(found))


@app.command()
def preview(
    folder: Folder,
    out: Annotated[Path, typer.Option(help="The file to write: .png or .jpg a contact sheet, .html a page.")],
    frames: Annotated[int, typer.Option(min=1, help="At most so many pictures on the page.")] = 60,
) -> None:
    """Show both cameras at every light level and in the tunnel, with their labels."""
    from adc_bench.dataset.layout import write_file
    from adc_bench.dataset.preview import page_of
    from adc_bench.dataset.read import FrameDataset

    kind = out.suffix.lower()
    if kind not in (".png", ".jpg", ".html"):
        raise UsageError(
            where="--out",
            found=str(out),
            wanted="a name that ends in .png, .jpg or .html",
            todo="name the picture or page so",
        )
    dataset = FrameDataset(folder)
    data = page_of(dataset, frames) if kind == ".html" else _sheet(dataset, kind)
    write_file(out, data)
    typer.echo(f"{out}: {len(data) / 1e6:.1f} MB")


def _sheet(dataset: "FrameDataset", kind: str) -> bytes:
    import cv2

    from adc_bench.dataset.preview import contact_sheet

    _, picture = cv2.imencode(kind, cv2.cvtColor(contact_sheet(dataset), cv2.COLOR_RGB2BGR))
    data: bytes = picture.tobytes()
    return data


@app.command()
def export(
    folder: Folder,
    format_name: Annotated[
        Literal["coco", "yolo", "webdataset", "tum", "kitti"], typer.Option("--format", help="What to write.")
    ],
    out: Annotated[str, typer.Option(help="A new folder or address, or one that this command began.")],
    split: Annotated[
        str | None, typer.Option("--as", help="The split's name in the export; its own if left out.")
    ] = None,
) -> None:
    """Write it as other tools read it; YOLO and WebDataset take several splits into one folder."""
    from adc_bench.dataset.export import export_dataset
    from adc_bench.dataset.read import FrameDataset

    with progress_bar("exporting pictures") as tell:
        done = export_dataset(FrameDataset(folder), format_name, out, split=split, progress=tell)
    typer.echo(f"{out}: {done.pictures} pictures of {done.split} as {format_name}")
    for note in done.notes:
        typer.echo(f"  {note}")
