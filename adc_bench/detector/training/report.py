"""What a training run shows of itself: a page with all that was measured, and a sheet of predictions."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from adc_bench.dataset.layout import write_file
from adc_bench.detector.evaluation import DetectionReport, Evaluation
from adc_bench.detector.evaluation.page import page_of
from adc_bench.detector.evaluation.sheet import sheet_png
from adc_bench.detector.training.checkpoint import EpochRecord

PAGE, SHEET = "report.html", "predictions.png"


def write_report(out: Path, evaluation: Evaluation, report: DetectionReport, history: Sequence[EpochRecord]) -> None:
    """Write page and sheet of a run's best weights into its folder."""
    what = f"The best weights of {len(history)} epochs, on the validation pictures."
    course = {"Course of the training": lambda figure: draw_history(figure, history)}
    write_file(out / PAGE, page_of(evaluation, report, what, course))
    write_file(out / SHEET, sheet_png(evaluation.source, evaluation.found, evaluation.threshold))


def draw_history(figure: Figure, history: Sequence[EpochRecord]) -> None:
    """Draw the losses and the validation score by epoch."""
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    epochs = [record.epoch + 1 for record in history]
    for name in history[0].losses:
        above.plot(epochs, [record.losses[name] for record in history], label=name)
    above.set(ylabel="training loss", yscale="symlog")
    scores = [(record.epoch + 1, record.validation) for record in history if record.validation]
    below.plot([epoch for epoch, _ in scores], [score.map for _, score in scores], "o-", label="mAP50-95")
    below.plot([epoch for epoch, _ in scores], [score.map50 for _, score in scores], "o-", label="mAP50")
    below.set(xlabel="epoch", ylabel="validation", ylim=(0, 1))
