"""The semantic camera: which labelled objects a camera has in view, and where they are, seen from the robot."""

import math
from collections.abc import Iterable, Sequence

from adc_bench.api import SeenObject
from adc_bench.geometry import Pose2, Pose3
from adc_bench.render.targets import Target
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Label


def objects_in_view(
    labels: Sequence[Label], targets: Iterable[Target], pose_world_robot: Pose3, range_max_m: float
) -> tuple[SeenObject, ...]:
    """Return the labelled objects that are no ignore region and whose middle is within range of the robot's.

    Poses and ranges are on the floor: where the object's origin is and which way its x axis points, seen from above.
    """
    where = {target.instance: target.pose_world_object for target in targets}
    pose_robot_world = _on_floor(pose_world_robot).inverse()
    seen = (
        SeenObject(
            category=CATEGORIES[label.category_id - 1],
            instance=label.instance,
            pose_robot_object=pose_robot_world @ _on_floor(where[label.instance]),
        )
        for label in labels
        if not label.ignore
    )
    return tuple(one for one in seen if _range_m(one) <= range_max_m)


def _range_m(one: SeenObject) -> float:
    return math.hypot(one.pose_robot_object.x_m, one.pose_robot_object.y_m)


def _on_floor(pose: Pose3) -> Pose2:
    x, y, _ = pose.translation_m
    return Pose2(x_m=float(x), y_m=float(y), yaw_rad=math.atan2(pose.rotation[1, 0], pose.rotation[0, 0]))
