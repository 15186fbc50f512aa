"""Targets where they are before a camera, all moved into its frame in one go."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.render.outlines import Pieces
from adc_bench.render.targets import Target

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Placed:
    """Targets, and their rotations (n, 3, 3) and places (n, 3) in the camera's frame."""

    targets: Sequence[Target]
    rotations: Array
    places: Array

    @classmethod
    def of(cls, targets: Sequence[Target], pose_camera_world: Pose3) -> "Placed":
        """Return targets seen from a camera."""
        poses = [target.pose_world_object for target in targets]
        rotations = np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3)
        places = np.array([pose.translation_m for pose in poses]).reshape(-1, 3)
        return cls(
            targets=targets,
            rotations=pose_camera_world.rotation @ rotations,
            places=pose_camera_world.transform(places),
        )

    def facing(self) -> "Placed":
        """Return those that turn their front to the camera, or have none."""
        fronts = np.array([target.front or (0.0, 0.0, 0.0) for target in self.targets]).reshape(-1, 3)
        corners = np.array([target.faces[0][0] for target in self.targets]).reshape(-1, 3)
        towards = ((self._moved(corners) * self._turned(fronts)).sum(axis=1) < 0.0).tolist()
        kept = [k for k, target in enumerate(self.targets) if target.front is None or towards[k]]
        return Placed(targets=[self.targets[k] for k in kept], rotations=self.rotations[kept], places=self.places[kept])

    def middles(self) -> Array:
        """Return the mean (n, 3) of each target's corners."""
        return self._moved(np.array([target.middle for target in self.targets]).reshape(-1, 3))

    def pieces(self) -> Pieces:
        """Return the convex pieces of all targets."""
        plain = Pieces.of([target.faces for target in self.targets])
        owner = plain.owners.repeat(plain.sizes)
        corners = np.einsum("nij,nj->ni", self.rotations[owner], plain.corners) + self.places[owner]
        return Pieces(corners=corners, sizes=plain.sizes, owners=plain.owners, count=plain.count)

    def keypoints(self) -> tuple[list[int], Array]:
        """Return which targets (k,) have keypoints, and these (k, 4, 3)."""
        some = [k for k, target in enumerate(self.targets) if target.keypoints is not None]
        points = np.array([self.targets[k].keypoints for k in some]).reshape(-1, 4, 3)
        return some, points @ self.rotations[some].transpose(0, 2, 1) + self.places[some][:, None]

    def _turned(self, ways: Array) -> Array:
        turned: Array = np.einsum("nij,nj->ni", self.rotations, ways)
        return turned

    def _moved(self, points: Array) -> Array:
        return self._turned(points) + self.places
