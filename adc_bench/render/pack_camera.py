"""A camera that sees the arena through one of SAPIEN's shader packs."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import cv2
import numpy as np
import sapien
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render.packs import Pack
from adc_bench.render.scene import sapien_pose
from adc_bench.render.view import FAR_M, NEAR_M, View

Radiance = NDArray[np.float32]
GAMMA = 2.2


def _new_scene() -> sapien.Scene:
    return sapien.Scene([sapien.render.RenderSystem()])


@dataclass(frozen=True, kw_only=True)
class Stage:
    """The SAPIEN scenes of one arena.

    Attributes:
        lit: what stands under the lights.
        shell: the hall's walls and ceiling, glowing with the light that falls on them. They are apart because they
            would keep the light of the floodlights and of the even sky out.
        cover: what stands under the lights again, without them: how much of a pixel it covers.
    """

    pack: Pack
    lit: sapien.Scene = field(default_factory=_new_scene)
    shell: sapien.Scene = field(default_factory=_new_scene)
    cover: sapien.Scene = field(default_factory=_new_scene)

    @property
    def background(self) -> Radiance:
        """The radiance (3,) that shows where nothing stands under the lights."""
        return np.asarray(self.lit.ambient_light, np.float32)


class PackView(View):
    """Draws what a camera sees with the pack: the colours from the stage, labels and depth from our own pack's."""

    def __init__(self, labels: sapien.Scene, stage: Stage, camera: Camera, *, with_depth: bool = False) -> None:
        super().__init__(labels, camera, with_depth=with_depth)
        self._stage, pack = stage, stage.pack
        self._lit = PackCamera(stage.lit, pack, self.pinhole, depth=pack.depth)
        self._shell = PackCamera(stage.shell, pack, self.pinhole, depth=0)
        # A path tracer's alpha counts every bounce; without bounces it is the share of the pixel that is covered.
        self._cover = PackCamera(stage.cover, pack, self.pinhole, depth=0) if pack.is_traced else self._lit

    def remove(self) -> None:
        """Take the cameras out of their scenes."""
        super().remove()
        for camera in {self._lit, self._shell, self._cover}:
            camera.remove()

    def take(self, pose_world_camera: Pose3, exposure_rgb: NDArray[np.float64]) -> None:
        """Draw the scene as it stands, to the end; `exposure_rgb` (3,) multiplies the light."""
        super().take(pose_world_camera, exposure_rgb)
        self._drawn = encoded(self.radiance(pose_world_camera) * exposure_rgb.astype(np.float32))

    def read(self) -> None:
        """Keep the picture taken."""
        super().read()
        self._pictures["Color"] = self._drawn

    def radiance(self, pose_world_camera: Pose3) -> Radiance:
        """Return the pinhole picture's radiance (h, w, 3) in units of a white surface under 300 lux."""
        lit, shell = self._lit.take(pose_world_camera), self._shell.take(pose_world_camera)
        cover = lit if self._cover is self._lit else self._cover.take(pose_world_camera)
        bare = 1 - np.clip(cover[..., 3:], 0, 1)
        return np.asarray(lit[..., :3] + bare * (shell[..., :3] - self._stage.background), np.float32)


class PackCamera:
    """One SAPIEN camera that draws with the pack."""

    def __init__(self, scene: sapien.Scene, pack: Pack, pinhole: Camera, *, depth: int) -> None:
        self._scene, self._picture, p = scene, pack.picture, pinhole
        with _ray_tracing(pack.samples, depth):
            self._component = sapien.render.RenderCameraComponent(p.width_px, p.height_px, pack.path)
            self._component.set_perspective_parameters(NEAR_M, FAR_M, p.fx_px, p.fy_px, p.cx_px, p.cy_px, 0.0)
            self._entity = sapien.Entity()
            self._entity.add_component(self._component)
            scene.add_entity(self._entity)

    def remove(self) -> None:
        """Take the camera out of the scene."""
        self._scene.remove_entity(self._entity)

    def take(self, pose_world_camera: Pose3, picture: str | None = None) -> Radiance:
        """Return a picture (h, w, 4) from a pose, the pack's radiance if no other is named."""
        self._entity.set_pose(sapien_pose(pose_world_camera))
        self._scene.update_render()  # before every picture: a path tracer adds to the last one otherwise
        self._component.take_picture()
        taken: Radiance = self._component.get_picture(picture or self._picture)
        return taken


def encoded(exposed: Radiance) -> NDArray[np.uint8]:
    """Return exposed radiance (h, w, 3) as our own pack writes it: RGBA uint8, gamma 2.2."""
    rgb = np.power(np.clip(exposed, 0, 1), np.float32(1 / GAMMA))
    return np.dstack([cv2.convertScaleAbs(rgb, alpha=255), np.full(rgb.shape[:2], 255, np.uint8)])


@contextmanager
def _ray_tracing(samples: int, depth: int) -> Iterator[None]:
    """Let cameras made inside trace so many paths a pixel; SAPIEN reads these settings when it makes a camera."""
    before = sapien.render.get_ray_tracing_samples_per_pixel(), sapien.render.get_ray_tracing_path_depth()
    sapien.render.set_ray_tracing_denoiser("none")
    sapien.render.set_ray_tracing_samples_per_pixel(max(samples, 1))
    sapien.render.set_ray_tracing_path_depth(depth)
    yield
    sapien.render.set_ray_tracing_samples_per_pixel(before[0])
    sapien.render.set_ray_tracing_path_depth(before[1])
