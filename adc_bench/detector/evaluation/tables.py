"""A report as tables: for the terminal, the page and the model card."""

from adc_bench.detector.evaluation.corners import SEEN_SCORE_MIN
from adc_bench.detector.evaluation.evaluation import DetectionReport
from adc_bench.detector.evaluation.operating import CROSSWALK_RANGE_M, Recall
from adc_bench.detector.evaluation.spread import Spread
from adc_bench.detector.evaluation.table import Table

NOTHING = "-"


def tables(report: DetectionReport) -> list[Table]:
    """Return all tables, the one with the most important figures first."""
    return [
        headline(report),
        _categories(report),
        _circumstances(report),
        _corners(report),
        _corner_by_corner(report),
        _floor(report),
        _calibration(report),
    ]


def headline(report: DetectionReport) -> Table:
    """Return the figures to compare detectors by."""
    overall, point = report.overall, report.operating
    low, high = CROSSWALK_RANGE_M
    invented = sum(point.invented_on_empty.values())
    rows = [
        ("mAP50-95", f"{overall.map:.3f}"),
        ("mAP50", f"{overall.map50:.3f}"),
        (f"precision at {point.threshold:g}", _share(point.precision)),
        (f"recall at {point.threshold:g}", _share(point.recall)),
        ("false crosswalks", f"{point.false_crosswalks} on {point.pictures_without_crosswalk} pictures without one"),
        ("detections on empty pictures", f"{invented} on {point.empty_pictures}"),
        *(
            (f"crosswalks found at {low:g}-{high:g} m, {name}", _recall(recall))
            for name, recall in point.crosswalk_recall.items()
        ),
        *(
            (
                f"crosswalk corners on the floor, {name}",
                f"median {_cm(score.found)}, p95 {_cm(score.found, p95=True)}",
            )
            for name, score in report.floor.items()
        ),
        ("calibration error", _share(report.calibration.expected_error)),
        ("threshold by the rule, here", f"{point.threshold_by_rule:g}"),
    ]
    return Table(
        title=f"{overall.pictures} pictures",
        columns=("", "figure"),
        rows=tuple(rows),
        note=f"Detections are believed from a score of {point.threshold:g} on; an object counts as found at an overlap "
        "of 0.50. Floor errors are those through the camera's true pose.",
    )


def _categories(report: DetectionReport) -> Table:
    rows = [
        (name, str(entry.objects), f"{entry.ap:.3f}", f"{entry.ap50:.3f}")
        for name, entry in report.overall.categories.items()
    ]
    return Table(
        "By category",
        ("category", "objects", "AP50-95", "AP50"),
        tuple(rows),
        "Average precision as COCO defines it: the mean over overlaps 0.50 to 0.95, and at 0.50.",
    )


def _circumstances(report: DetectionReport) -> Table:
    rows = [
        (
            f"{kind}: {name}",
            str(part.recall.objects),
            f"{part.score.map:.3f}",
            f"{part.score.map50:.3f}",
            _share(part.recall.recall),
        )
        for kind, parts in report.circumstances.items()
        for name, part in parts.items()
    ]
    return Table(
        "By circumstance",
        ("circumstance", "objects", "mAP50-95", "mAP50", "recall"),
        tuple(rows),
        "Light, tunnel and blur part the pictures. Size, distance and visible fraction part the objects: those outside "
        "a band are ignored. A detection of nothing counts against its own size, but against every band of distance "
        "and of visible fraction, for nobody knows which would be its own: compare average precision there with other "
        f"detectors in the same row only. The recall, at a score of {report.operating.threshold:g}, compares between "
        "rows as well.",
    )


def _corners(report: DetectionReport) -> Table:
    rows = [
        (
            kind,
            str(score.error_px.count),
            _px(score.error_px.median),
            _px(score.error_px.p95),
            _share(score.within_one_sigma),
            _share(score.within_two_sigma),
            _share(score.said_right),
            _share(score.seen_said),
        )
        for kind, score in report.corners.items()
    ]
    return Table(
        "Corners in the picture",
        ("of", "corners", "median px", "p95 px", "within 1 sigma", "within 2 sigma", "said seen: are", "seen: said so"),
        tuple(rows),
        "The seen corners of the objects found. An honest standard deviation holds 0.757 of the errors along u and v, "
        f"and twice it 0.941 (Laplace). A corner is said to be seen from a score of {SEEN_SCORE_MIN:g} on.",
    )


def _corner_by_corner(report: DetectionReport) -> Table:
    rows = [
        (f"{kind}, {name}", str(each.count), _px(each.median), _px(each.p95))
        for kind, score in report.corners.items()
        for name, each in score.each_px.items()
    ]
    return Table("Corner by corner", ("corner", "corners", "median px", "p95 px"), tuple(rows), "As above.")


def _floor(report: DetectionReport) -> Table:
    rows = [
        (
            name,
            str(score.found.count),
            *(
                _cm(spread, p95=p95)
                for spread in (score.found, score.found_nominal, score.nominal)
                for p95 in (False, True)
            ),
        )
        for name, score in report.floor.items()
    ]
    return Table(
        "Crosswalk corners on the floor",
        ("away", "corners", "true pose: median", "p95", "nominal: median", "p95", "mount alone: median", "p95"),
        tuple(rows),
        "The seen corners of the crosswalks found, by distance from the camera along the floor: cast on it through "
        "the camera's true pose; through its nominal mount on a level robot at its true place; and the true corners "
        "through the nominal mount, which is what the tilt of camera and body costs alone.",
    )


def _calibration(report: DetectionReport) -> Table:
    rows = [
        (f"{each.low:g}-{each.high:g}", str(each.count), _share(each.mean_score), _share(each.right))
        for each in report.calibration.bins
    ]
    return Table(
        "Calibration",
        ("score", "detections", "mean score", "right"),
        tuple(rows),
        f"Expected calibration error: {_share(report.calibration.expected_error)}.",
    )


def _share(value: float | None) -> str:
    return NOTHING if value is None else f"{value:.3f}"


def _px(value: float | None) -> str:
    return NOTHING if value is None else f"{value:.2f}"


def _cm(spread: Spread, *, p95: bool = False) -> str:
    value_m = spread.p95 if p95 else spread.median
    return NOTHING if value_m is None else f"{100 * value_m:.1f} cm"


def _recall(recall: Recall) -> str:
    return f"{_share(recall.recall)} ({recall.found} of {recall.objects})"
