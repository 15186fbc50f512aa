"""An evaluation as a page that needs nothing beside itself: figures, the worst mistakes, tables."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from html import escape

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.evaluation.evaluation import DetectionReport, Evaluation
from adc_bench.detector.evaluation.figures import drawings
from adc_bench.detector.evaluation.mistakes import Mistake, invented, misplaced, missed
from adc_bench.detector.evaluation.table import Table
from adc_bench.detector.evaluation.tables import tables
from adc_bench.pages import data_url, figure, grid, report, table
from adc_bench.pages.drawing import INKS, Draw, png

MISTAKES_MOST = 8
JPEG_QUALITY = 88
KINDS: Mapping[str, tuple[str, Callable[[Evaluation, int], Iterator[Mistake]]]] = {
    "Invented": ("The surest detections of nothing. Green: truth; grey: regions to ignore; orange: answers.", invented),
    "Missed": ("The largest objects not found, drawn likewise.", missed),
    "Corners far off": ("From the true corners (green) to those found (orange).", misplaced),
}


def page_of(
    evaluation: Evaluation, measured: DetectionReport, what: str, more: Mapping[str, Draw] | None = None
) -> bytes:
    """Return the HTML; `what` says what was evaluated, `more` are further figures. Equal inputs give equal bytes."""
    first, *others = tables(measured)
    figures = {**drawings(evaluation, measured), **(more or {})}
    body = (
        grid((_table(first), *(_figure(title, draw) for title, draw in figures.items()))),
        *(_mistakes(title, *parts, evaluation) for title, parts in KINDS.items()),
        "<h2>Tables</h2>",
        grid(_table(other) for other in others),
    )
    return report("adc-bench detector", what, "\n".join(body))


def _figure(title: str, draw: Draw) -> str:
    return figure(title, *(png(draw, INKS[paper]) for paper in ("light", "dark")))


def _mistakes(
    title: str, note: str, chosen: Callable[[Evaluation, int], Iterable[Mistake]], evaluation: Evaluation
) -> str:
    crops = "\n".join(_crop(mistake) for mistake in chosen(evaluation, MISTAKES_MOST))
    body = f'<div class="crops">\n{crops}\n</div>' if crops else "<p>None.</p>"
    return f'<h2>{escape(title)}</h2>\n<p class="note">{escape(note)}</p>\n{body}'


def _crop(mistake: Mistake) -> str:
    source = data_url(_jpeg(mistake.rgb), "jpeg")
    return f'<figure><img alt="" src="{source}"><figcaption>{escape(mistake.told)}</figcaption></figure>'


def _table(one: Table) -> str:
    return table(one.title, one.note, one.columns, one.rows)


def _jpeg(rgb: NDArray[np.uint8]) -> bytes:
    _, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return data.tobytes()
