"""YOLO: `images/<split>/*.jpg`, `labels/<split>/*.txt` and `data.yaml`, as Ultralytics reads them.

A label's line is class (from 0), centre x and y, width and height, as shares of the picture's sides; a picture without
objects has an empty file. The format knows no regions to ignore: they are left out, so what they hold counts as
background. `data.yaml` names no path: its own folder is meant then, wherever that is moved.
"""

from collections.abc import Iterator, Sequence

from adc_bench.dataset.export.format import ROLES, Format, picture_file, write_pictures
from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.store import Store
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Label


def write(dataset: FrameDataset, split: str, out: Store) -> Iterator[int]:
    """Write pictures and labels; yield how many are done."""

    def files(i: int) -> dict[str, bytes]:
        labels = [label for label in dataset.annotations(i) if not label.ignore]
        lines = [_line(label, dataset.width_px, dataset.height_px) for label in labels]
        return {
            f"images/{split}/{picture_file(dataset, i)}": dataset.jpeg(i),
            f"labels/{split}/{i:06d}.txt": "".join(lines).encode(),
        }

    return write_pictures(dataset, out, files)


def finish(out: Store, splits: Sequence[str]) -> tuple[str, ...]:
    """Write `data.yaml` of the splits that are there."""
    lines = [f"{role}: images/{role}" for role in ROLES if role in splits]
    lines += [f"nc: {len(CATEGORIES)}", "names:", *(f"  {k}: {name}" for k, name in enumerate(CATEGORIES))]
    out.write("data.yaml", ("\n".join(lines) + "\n").encode())
    missing = [role for role in ("train", "val") if role not in splits]
    return tuple(f"Ultralytics wants {role} too: export such a dataset into the same folder" for role in missing)


def _line(label: Label, width_px: int, height_px: int) -> str:
    x0, y0, x1, y1 = label.box_px
    shares = (x0 + x1) / 2 / width_px, (y0 + y1) / 2 / height_px, (x1 - x0) / width_px, (y1 - y0) / height_px
    return f"{label.category_id - 1} " + " ".join(f"{share:.8f}" for share in shares) + "\n"


FORMAT = Format(write=write, finish=finish, splits=ROLES, joins=True)
