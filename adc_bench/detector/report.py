"""Figures of a training run: the course of losses and score, precision-recall curves, predictions beside the truth."""

import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from adc_bench.dataset.layout import write_file
from adc_bench.detector.checkpoint import EpochRecord
from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.evaluation.score import RECALLS, Curve
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Detections

SHOWN_SCORE_MIN = 0.25
TRUTH_RGB, IGNORED_RGB, FOUND_RGB = (90, 255, 90), (160, 160, 160), (255, 170, 60)


def draw_history(path: Path, history: Sequence[EpochRecord]) -> None:
    """Write the losses and the validation score by epoch as PNG."""
    figure, (left, right) = _figure(10, 4, columns=2)
    epochs = [record.epoch + 1 for record in history]
    for name in history[0].losses:
        left.plot(epochs, [record.losses[name] for record in history], label=name)
    left.set(xlabel="epoch", ylabel="training loss", yscale="symlog")
    scores = [(record.epoch + 1, record.validation) for record in history if record.validation]
    right.plot([epoch for epoch, _ in scores], [score.map for _, score in scores], "o-", label="mAP50-95")
    right.plot([epoch for epoch, _ in scores], [score.map50 for _, score in scores], "o-", label="mAP50")
    right.set(xlabel="epoch", ylabel="validation", ylim=(0, 1))
    _save(path, figure, (left, right))


def draw_curves(path: Path, curves: Mapping[str, Curve]) -> None:
    """Write the precision-recall curves at overlap 0.50 as PNG."""
    figure, (axes,) = _figure(6, 5, columns=1)
    for name, curve in curves.items():
        axes.plot(RECALLS, curve.precision, label=f"{name} {curve.ap50:.3f}")
    axes.set(
        xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1.02), title="average precision at overlap 0.50"
    )
    _save(path, figure, (axes,))


def draw_predictions(
    path: Path, source: LabelledPictures, found: Sequence[Detections], *, rows: int = 6, columns: int = 3
) -> None:
    """Write a sheet as PNG of pictures with objects, spread over the dataset: in each pair the truth on the left, the
    predictions on the right.
    """
    busy = [i for i in range(len(source)) if any(not label.ignore for label in source.annotations(i))]
    count = min(rows * columns, len(busy))
    chosen = [busy[round(k)] for k in np.linspace(0, len(busy) - 1, count)]
    pairs = [np.hstack([_draw_truth(source, i), _draw_found(source.picture(i), found[i])]) for i in chosen]
    blank = np.zeros_like(pairs[0])
    pairs += [blank] * (-len(pairs) % columns)
    sheet = np.vstack([np.hstack(pairs[k : k + columns]) for k in range(0, len(pairs), columns)])
    _, png = cv2.imencode(".png", cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR))
    write_file(path, png.tobytes())


def _draw_truth(source: LabelledPictures, index: int) -> NDArray[np.uint8]:
    canvas = source.picture(index).copy()
    for label in source.annotations(index):
        colour = IGNORED_RGB if label.ignore else TRUTH_RGB
        _draw_box(canvas, label.box_px, "ignored" if label.ignore else CATEGORIES[label.category_id - 1], colour)
    return canvas


def _draw_found(picture: NDArray[np.uint8], found: Detections) -> NDArray[np.uint8]:
    canvas = picture.copy()
    for box, score, category_id in zip(found.boxes_px, found.scores, found.category_ids, strict=True):
        if score >= SHOWN_SCORE_MIN:
            _draw_box(canvas, box, f"{CATEGORIES[category_id - 1]} {score:.2f}", FOUND_RGB)
    return canvas


def _draw_box(canvas: NDArray[np.uint8], box: Sequence[float], text: str, colour: tuple[int, int, int]) -> None:
    x0, y0, x1, y1 = (round(float(value)) for value in box)
    cv2.rectangle(canvas, (x0, y0), (x1 - 1, y1 - 1), colour, 1)
    at = (min(x0, canvas.shape[1] - 8 * len(text)), y0 - 4 if y0 > 16 else y0 + 14)
    cv2.putText(canvas, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, colour, 1, cv2.LINE_AA)


def _figure(width_in: float, height_in: float, *, columns: int) -> tuple[Figure, Sequence[Axes]]:
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, tuple(figure.subplots(1, columns, squeeze=False)[0])


def _save(path: Path, figure: Figure, all_axes: Sequence[Axes]) -> None:
    for axes in all_axes:
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    write_file(path, buffer.getvalue())
