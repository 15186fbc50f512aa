"""Labels: what the picture of label ids shows of each object, and what the whole object would look like."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render.keypoints import keypoints_of
from adc_bench.render.outlines import outlines_of
from adc_bench.render.placed import Placed
from adc_bench.render.runs import regions
from adc_bench.render.targets import Target
from adc_bench.world.frame import Label

# An object is an ignore region below so many pixels at 320 x 240 (they grow with the picture), below that visible share
# of what lies in the picture, and beyond that share outside it: nobody can say what a corner is a corner of.
VISIBLE_PX_MIN = 40
VISIBLE_FRACTION_MIN = 0.2
TRUNCATION_MAX = 0.9


def labels_of(
    ids: NDArray[np.uint8], targets: Sequence[Target], camera: Camera, pose_world_camera: Pose3
) -> tuple[Label, ...]:
    """Return the labels of every target with at least one visible pixel and its front towards the camera.

    `ids` (h, w) holds the label ids of the delivered picture, that is: seen through the distorting lens.
    """
    shown = regions(ids, [target.label_id for target in targets])
    seen = Placed.of([target for target in targets if target.label_id in shown], pose_world_camera.inverse()).facing()
    whole = outlines_of(seen.pieces(), camera)
    keypoints = keypoints_of(ids, seen, whole.shapes_px, camera)
    distances_m = np.linalg.norm(seen.middles(), axis=1).tolist()
    small_px = VISIBLE_PX_MIN * (camera.width_px * camera.height_px) / (320 * 240)
    labels = []
    for k, target in enumerate(seen.targets):
        region = shown[target.label_id]
        fraction = min(1.0, region.visible_px / max(whole.areas_px[k], 1.0))
        hidden = fraction < VISIBLE_FRACTION_MIN or whole.truncations[k] > TRUNCATION_MAX
        labels.append(
            Label(
                category_id=target.category_id,
                instance=target.instance,
                box_px=region.box_px,
                amodal_box_px=whole.boxes_px[k] or region.box_px,
                amodal_box_whole_px=whole.boxes_whole_px[k] or region.box_px,
                mask_rle=region.mask_rle,
                visible_px=region.visible_px,
                visible_fraction=fraction,
                truncation=whole.truncations[k],
                distance_m=distances_m[k],
                pose_world_object=target.figures,
                keypoints_px=keypoints[k],
                ignore=region.visible_px < small_px or hidden,
            )
        )
    return tuple(labels)
