"""The measured arena as files for another simulator: scene.json with its shapes and camera poses, floor.png."""

import json
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from arenas import STOPS, stops

from adc_bench.geometry import Pose3
from adc_bench.render.textures import course_bounds, paint_mask
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import CameraMount
from adc_bench.world.solids import Solid

FLOOR_GREY, LINE_WHITE, GRAIN_SD = 60, 215, 8.0  # of 255


def write_scene(scenario: Scenario, mount: CameraMount, folder: Path) -> None:
    """Write both files. Poses and attitudes are 3x3 rotations (row by row) with x forward, y left, z up."""
    spec = scenario.arena_spec
    cv2.imwrite(str(folder / "floor.png"), _floor(scenario))
    shapes = [_shape(solid, solid.pose_world_solid()) for solid in scenario.solids]
    for body in scenario.bodies:
        shapes += [_shape(part, body.pose.to_pose3() @ part.pose_world_solid()) for part in body.parts]
    cameras = [pose @ mount.pose_robot_camera() for pose in islice(stops(scenario), STOPS)]
    scene = {
        "hall_m": [spec.hall_half_length_m, spec.hall_half_width_m, spec.hall_height_m],
        "floor_bounds_m": course_bounds(scenario.course_spec),
        "shapes": shapes,
        "fovy_rad": 2 * np.arctan(mount.height_px / 2 / mount.camera().fy_px),
        "cameras": [{"position_m": p.translation_m.tolist(), "optical": p.rotation.ravel().tolist()} for p in cameras],
    }
    (folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")


def _shape(solid: Solid, pose: Pose3) -> dict[str, Any]:
    return {
        "shape": solid.shape,
        "position_m": pose.translation_m.tolist(),
        "rotation": pose.rotation.ravel().tolist(),
        "size_m": solid.size_m,
        "albedo": solid.albedo,
    }


def _floor(scenario: Scenario) -> np.ndarray:
    """Return the painted floor (h, w) uint8, as fine as ours."""
    paint = paint_mask(scenario.course_spec).astype(np.float32) / 255
    grain = np.random.default_rng(0).normal(0.0, GRAIN_SD, paint.shape).astype(np.float32)
    return np.clip(FLOOR_GREY + (LINE_WHITE - FLOOR_GREY) * paint + grain, 0, 255).astype(np.uint8)
