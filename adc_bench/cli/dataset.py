"""`adc-bench dataset`: check a dataset, look at it."""

import json
from pathlib import Path
from typing import Annotated, Literal

import typer

from adc_bench.cli.progress import progress_bar
from adc_bench.errors import InputError, UsageError

app = typer.Typer(
    help="Check a dataset, look at it.", no_args_is_help=True, rich_markup_mode=None, pretty_exceptions_enable=False
)
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="The dataset's folder.")]


@app.command()
def check(
    folder: Folder, as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False
) -> None:
    """Read every picture, label and pose; exit 3 if anything is wrong."""
    from adc_bench.dataset.check import find_problems
    from adc_bench.dataset.read import FrameDataset

    dataset = FrameDataset(folder)
    problems = list(find_problems(dataset))
    if as_json:
        typer.echo(json.dumps({"frames": len(dataset), "problems": problems}, indent=2))
    else:
        for problem in problems:
            typer.echo(problem)
    if problems:
        raise InputError(
            where=str(folder),
            found=f"{len(problems)} problems, the first: {problems[0]}",
            wanted="a dataset as it was written",
            todo="copy it again, or render it again",
        )
    if not as_json:
        boxes = sum(len(dataset.annotations(i)) for i in range(len(dataset)))
        typer.echo(f"{folder}: {len(dataset)} frames and {boxes} labels are in order")


@app.command()
def preview(folder: Folder, out: Annotated[Path, typer.Option(help="The PNG or JPEG file to write.")]) -> None:
    """Write a contact sheet: both cameras at every light level and in the tunnel, with their boxes."""
    import cv2

    from adc_bench.dataset.layout import write_file
    from adc_bench.dataset.preview import contact_sheet
    from adc_bench.dataset.read import FrameDataset

    if out.suffix.lower() not in (".png", ".jpg"):
        raise UsageError(
            where="--out", found=str(out), wanted="a name that ends in .png or .jpg", todo="name the picture so"
        )
    sheet = contact_sheet(FrameDataset(folder))
    _, picture = cv2.imencode(out.suffix.lower(), cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR))
    write_file(out, picture.tobytes())
    typer.echo(f"{out}: {sheet.shape[1]}x{sheet.shape[0]} pixels")


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
