"""A camera in the scene: our shader pack's pictures through a lens, colour, label ids and depth."""

from importlib import resources

import cv2
import numpy as np
import sapien
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render.lens import Warp
from adc_bench.render.motion_blur import Flow
from adc_bench.render.scene import sapien_pose

NEAR_M, FAR_M = 0.05, 40.0


def use_arena_pack() -> None:
    """Let SAPIEN's cameras draw with our shader pack; must run before the first camera is made."""
    sapien.render.set_camera_shader_dir(str(resources.files("adc_bench.render") / "shaders" / "arena"))
    sapien.render.set_picture_format("Color", "r8g8b8a8unorm")
    sapien.render.set_picture_format("Label", "r8g8b8a8unorm")


class View:
    """Draws what a camera sees: as a pinhole picture wide enough, then behind the camera's lens.

    With depth it also keeps SAPIEN's depth buffer, which is drawn anyway.
    """

    def __init__(self, scene: sapien.Scene, camera: Camera, *, with_depth: bool = False) -> None:
        """Raises InputError for a lens that folds the picture's border back."""
        self.camera, self.pinhole = camera, camera.covering_pinhole()
        self._scene, self._warp = scene, Warp(camera, self.pinhole)
        self._pictures: dict[str, NDArray[np.uint8]] = {}
        self._depth: NDArray[np.float32] | None = None
        self._with_depth = with_depth
        p = self.pinhole
        self._component = sapien.render.RenderCameraComponent(p.width_px, p.height_px)
        self._component.set_perspective_parameters(NEAR_M, FAR_M, p.fx_px, p.fy_px, p.cx_px, p.cy_px, 0.0)
        self._entity = sapien.Entity()
        self._entity.add_component(self._component)
        scene.add_entity(self._entity)

    def remove(self) -> None:
        """Take the camera out of the scene."""
        self._scene.remove_entity(self._entity)

    def take(self, pose_world_camera: Pose3, exposure_rgb: NDArray[np.float64]) -> None:
        """Begin to draw the scene as it stands; `exposure_rgb` (3,) multiplies the light.

        The driver draws in threads of its own; what was read before stays until `read`.
        """
        self._entity.set_pose(sapien_pose(pose_world_camera))
        self._scene.set_ambient_light(exposure_rgb.tolist())
        self._scene.update_render()
        self._component.take_picture()

    def read(self) -> None:
        """Wait until the picture taken is drawn, and keep it."""
        self._pictures = {name: self._component.get_picture(name) for name in ("Color", "Label")}
        if self._with_depth:
            self._depth = self._component.get_picture("GbufferDepth")  # 0 at NEAR_M, 1 at FAR_M

    def colour(self, flow: Flow | None = None) -> NDArray[np.uint8]:
        """Return the picture read, (h, w, 4), blurred along the flow if there is one."""
        return self._warp.colour(self._pictures["Color"], flow)

    def label_ids(self) -> NDArray[np.uint8]:
        """Return the label ids (h, w) of the picture read."""
        return self._warp.ids(np.asarray(cv2.extractChannel(self._pictures["Label"], 0), np.uint8))

    def depth_m(self) -> NDArray[np.float32]:
        """Return the distance (h, w) along the camera's axis of what each pixel's centre shows, in the picture read.

        Only of a view with depth. At most `FAR_M`.
        """
        assert self._depth is not None, "a view with depth, and a picture read"
        inverse = (1 - self._depth) * np.float32(1 / NEAR_M - 1 / FAR_M) + np.float32(1 / FAR_M)
        return np.asarray(1 / np.clip(self._warp.affine(inverse), 1 / FAR_M, 1 / NEAR_M), np.float32)
