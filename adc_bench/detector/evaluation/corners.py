"""How far the corners that a detector finds lie from the true ones in the picture, and whether it knows."""

from collections.abc import Sequence
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.evaluation.matching import Matches
from adc_bench.detector.evaluation.spread import Spread, rounded, share, spread_of
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID
from adc_bench.world.corners_seen import keypoints_as_seen
from adc_bench.world.frame import KEYPOINT_VISIBLE

SEEN_SCORE_MIN = 0.5
KINDS = ("crosswalk", "panel", "sign")
CORNERS = {
    "crosswalk": ("far left", "far right", "near right", "near left"),
    "panel": ("top left", "top right", "bottom right", "bottom left"),
    "sign": ("top left", "top right", "bottom right", "bottom left"),
}


class CornerScore(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The corners of one kind of object: those that are seen, of the objects found at the operating threshold.

    Attributes:
        error_px: distance to the true corner, in all and corner by corner.
        within_one_sigma, within_two_sigma: share of the errors along u and along v that are no larger than the standard
            deviation said of them, and than twice that. An honest Laplace distribution has 0.757 and 0.941.
        said_right: share of the corners said to be seen that are.
        seen_said: share of the corners seen that are said to be.
    """

    error_px: Spread
    each_px: dict[str, Spread]
    within_one_sigma: float | None
    within_two_sigma: float | None
    said_right: float | None
    seen_said: float | None


class FoundCorners(NamedTuple):
    """The four corners of the k objects found: index of the label and of the detection (k,), true places (k, 4, 2) px
    and whether they are seen (k, 4).
    """

    label: NDArray[np.int64]
    detection: NDArray[np.int64]
    true_px: NDArray[np.float32]
    seen: NDArray[np.bool_]

    def of(self, rows: NDArray[np.bool_]) -> "FoundCorners":
        """Return some of the objects."""
        return FoundCorners(self.label[rows], self.detection[rows], self.true_px[rows], self.seen[rows])


def found_corners(source: LabelledPictures, matches: Matches, threshold: float) -> FoundCorners:
    """Return the corners of the objects found at this score or above."""
    true = true_corners(source)
    label = np.flatnonzero(matches.asked & (matches.found_score() >= threshold))
    return FoundCorners(
        label, matches.found_by[label], true[label, :, :2], (true[label, :, 2] == KEYPOINT_VISIBLE).astype(np.bool_)
    )


def true_corners(source: LabelledPictures) -> NDArray[np.float32]:
    """Return the keypoints of all labels (t, 4, 3) in the order of `Detections`."""
    each = [
        keypoints_as_seen(source.annotations(i), towards_plus_x=source.pose_world_camera(i)[0, 2] > 0)
        for i in range(len(source))
    ]
    return np.concatenate([np.zeros((0, 4, 3), np.float32), *each])


def corner_scores(matches: Matches, found: FoundCorners) -> dict[str, CornerScore]:
    """Return the score of each kind of object that has corners."""
    kinds = np.array([kind_of(matches.category_ids[k]) for k in found.detection])
    return {kind: _score(matches, found.of(kinds == kind), CORNERS[kind]) for kind in KINDS}


def kind_of(category_id: int) -> str:
    """Return the part of a category's name before the underscore."""
    return CATEGORIES[category_id - 1].split("_")[0]


def errors_px(matches: Matches, found: FoundCorners) -> NDArray[np.float32]:
    """Return the errors (k, 4, 2) along u and v."""
    errors: NDArray[np.float32] = matches.keypoints_px[found.detection] - found.true_px
    return errors


def crosswalks(matches: Matches, found: FoundCorners) -> FoundCorners:
    """Return the crosswalks among the objects found."""
    return found.of(matches.category_ids[found.detection] == CATEGORY_ID["crosswalk"])


def _score(matches: Matches, found: FoundCorners, names: Sequence[str]) -> CornerScore:
    errors, seen = errors_px(matches, found), found.seen
    distance = np.hypot(errors[..., 0], errors[..., 1])
    in_sigmas = (np.abs(errors) / matches.keypoint_sigma_px[found.detection][..., None])[seen]
    said = matches.keypoint_scores[found.detection] >= SEEN_SCORE_MIN
    return CornerScore(
        error_px=spread_of(distance[seen]),
        each_px={name: spread_of(distance[seen[:, k], k]) for k, name in enumerate(names)},
        within_one_sigma=rounded((in_sigmas <= 1).mean()) if in_sigmas.size else None,
        within_two_sigma=rounded((in_sigmas <= 2).mean()) if in_sigmas.size else None,
        said_right=share((said & seen).sum(), said.sum()),
        seen_said=share((said & seen).sum(), seen.sum()),
    )
