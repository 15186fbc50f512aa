"""An evaluation as a page that needs nothing beside itself: figures, the worst mistakes, tables."""

import base64
from collections.abc import Callable, Iterable, Iterator, Mapping
from html import escape
from importlib.resources import files
from string import Template

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.evaluation.evaluation import DetectionReport, Evaluation
from adc_bench.detector.evaluation.figures import INKS, Draw, drawings, png
from adc_bench.detector.evaluation.mistakes import Mistake, invented, misplaced, missed
from adc_bench.detector.evaluation.table import Table
from adc_bench.detector.evaluation.tables import tables

MISTAKES_MOST = 8
JPEG_QUALITY = 88
KINDS: Mapping[str, tuple[str, Callable[[Evaluation, int], Iterator[Mistake]]]] = {
    "Invented": ("The surest detections of nothing. Green: truth; grey: regions to ignore; orange: answers.", invented),
    "Missed": ("The largest objects not found, drawn likewise.", missed),
    "Corners far off": ("From the true corners (green) to those found (orange).", misplaced),
}


def page_of(
    evaluation: Evaluation, report: DetectionReport, what: str, more: Mapping[str, Draw] | None = None
) -> bytes:
    """Return the HTML; `what` says what was evaluated, `more` are further figures. Equal inputs give equal bytes."""
    template = Template(files("adc_bench.detector.evaluation").joinpath("page.html").read_text(encoding="utf-8"))
    first, *others = tables(report)
    page = template.substitute(
        title=escape("adc-bench detector"),
        headline=escape(what),
        first=_table(first),
        figures="\n".join(
            _figure(title, draw) for title, draw in {**drawings(evaluation, report), **(more or {})}.items()
        ),
        mistakes="\n".join(_mistakes(title, *parts, evaluation) for title, parts in KINDS.items()),
        tables="\n".join(_table(table) for table in others),
    )
    return page.encode()


def _figure(title: str, draw: Draw) -> str:
    light, dark = (_data(png(draw, INKS[paper]), "png") for paper in ("light", "dark"))
    return (
        f'<figure><h3>{escape(title)}</h3><picture><source media="(prefers-color-scheme: dark)" srcset="{dark}">'
        f'<img alt="{escape(title)}" src="{light}"></picture></figure>'
    )


def _mistakes(
    title: str, note: str, chosen: Callable[[Evaluation, int], Iterable[Mistake]], evaluation: Evaluation
) -> str:
    crops = "\n".join(_crop(mistake) for mistake in chosen(evaluation, MISTAKES_MOST))
    body = f'<div class="crops">\n{crops}\n</div>' if crops else "<p>None.</p>"
    return f'<h2>{escape(title)}</h2>\n<p class="note">{escape(note)}</p>\n{body}'


def _crop(mistake: Mistake) -> str:
    source = _data(_jpeg(mistake.rgb), "jpeg")
    return f'<figure><img alt="" src="{source}"><figcaption>{escape(mistake.told)}</figcaption></figure>'


def _table(table: Table) -> str:
    columns = "".join(f"<th>{escape(name)}</th>" for name in table.columns)
    rows = "\n".join(
        f"<tr><th>{escape(row[0])}</th>{''.join(f'<td>{escape(cell)}</td>' for cell in row[1:])}</tr>"
        for row in table.rows
    )
    wide = ' class="wide"' if len(table.columns) > 5 else ""
    return (
        f'<section{wide}><h3>{escape(table.title)}</h3><p class="note">{escape(table.note)}</p>'
        f"<table><thead><tr>{columns}</tr></thead><tbody>\n{rows}\n</tbody></table></section>"
    )


def _jpeg(rgb: NDArray[np.uint8]) -> bytes:
    _, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return data.tobytes()


def _data(content: bytes, kind: str) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(content).decode()}"
