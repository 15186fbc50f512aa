"""Reading the signal panel: a sign counts once it was seen in enough pictures running, and none that is cut off."""

from dataclasses import dataclass, replace

from adc_bench.world.categories import CATEGORY_ID, PANEL_SIGNS, PanelSign
from adc_bench.world.frame import Detections
from adc_bench.world.sensors import CameraMount

SIDE_PX = 3.0  # a box that ends so near to a side of the picture is cut off there

SIGN_OF_CATEGORY: dict[int, PanelSign] = {CATEGORY_ID[f"panel_{sign}"]: sign for sign in PANEL_SIGNS}


@dataclass(frozen=True, kw_only=True)
class PanelParams:
    """What is needed to believe a sign."""

    least_score: float = 0.4
    pictures: int = 2


@dataclass(frozen=True, kw_only=True)
class PanelReading:
    """The sign believed in, and the candidate that would replace it with how often it was seen running."""

    sign: PanelSign | None = None
    candidate: PanelSign | None = None
    count: int = 0


def uncut(detections: Detections, mount: CameraMount) -> Detections:
    """Return the detections that no side of the picture cuts off: half a sign is easily another one."""
    left, right = detections.boxes_px[:, 0], detections.boxes_px[:, 2]
    return detections.of((left > SIDE_PX) & (right < mount.width_px - SIDE_PX))


def seen_sign(detections: Detections, least_score: float) -> PanelSign | None:
    """Return the best-scoring panel sign, or None."""
    for category, score in zip(detections.category_ids, detections.scores, strict=True):
        if int(category) in SIGN_OF_CATEGORY and score >= least_score:
            return SIGN_OF_CATEGORY[int(category)]
    return None


def read_panel(before: PanelReading, detections: Detections, params: PanelParams | None = None) -> PanelReading:
    """Return the reading after one more picture; a picture without a sign changes nothing believed, but ends a run."""
    p = params or PanelParams()
    sign = seen_sign(detections, p.least_score)
    count = 0 if sign is None else before.count + 1 if sign == before.candidate else 1
    reading = replace(before, candidate=sign, count=count)
    return replace(reading, sign=sign) if sign is not None and count >= p.pictures else reading
