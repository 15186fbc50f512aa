"""The arena renderer: one scenario at a time, pictures from the rig's cameras, labels with them."""

from collections import Counter
from collections.abc import Mapping
from importlib import resources

import cv2
import numpy as np
import sapien
from numpy.typing import NDArray

from adc_bench.geometry import Pose2, Pose3
from adc_bench.render.driver import choose_software_driver
from adc_bench.render.labels import labels_of
from adc_bench.render.light import exposure_for
from adc_bench.render.picture import deliver
from adc_bench.render.scene import StaticScene, sapien_pose
from adc_bench.world.arena import road_centre, tunnel_s_on_centre
from adc_bench.world.categories import PanelSign
from adc_bench.world.frame import Conditions, Frame
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import CameraMount, SensorRig
from adc_bench.world.streams import stream

NEAR_M, FAR_M = 0.05, 40.0
# Floor points, in the robot frame, whose light the exposure follows.
METERED = np.array([[x, y] for x in (0.6, 1.1, 1.6) for y in (-0.4, 0.0, 0.4)])
NOISE_SD_BRIGHT, NOISE_SD_DARK = 1.0, 5.0  # of 255, at the lowest and at the highest exposure
EXPOSURE_DARK = 4.0


class ArenaRenderer:
    """Renders scenarios on the software Vulkan driver; one a process, reused from scenario to scenario."""

    def __init__(self, rig: SensorRig) -> None:
        """Raises MachineError if the software driver is not installed."""
        choose_software_driver()
        sapien.render.set_camera_shader_dir(str(resources.files("adc_bench.render") / "shaders" / "arena"))
        sapien.render.set_picture_format("Color", "r8g8b8a8unorm")
        sapien.render.set_picture_format("Label", "r8g8b8a8unorm")
        self.rig = rig
        self._system = sapien.render.RenderSystem()
        self._scene = sapien.Scene([self._system])
        self._cameras: Mapping[str, sapien.render.RenderCameraComponent] = {
            mount.name: self._add_camera(mount) for mount in rig.cameras
        }
        self._static: StaticScene | None = None

    @property
    def device_name(self) -> str:
        """The Vulkan device's name with its version."""
        return str(self._system.device.name)

    def _add_camera(self, mount: CameraMount) -> sapien.render.RenderCameraComponent:
        camera = mount.camera()
        component = sapien.render.RenderCameraComponent(mount.width_px, mount.height_px)
        component.set_perspective_parameters(NEAR_M, FAR_M, camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, 0.0)
        entity = sapien.Entity()
        entity.add_component(component)
        self._scene.add_entity(entity)
        return component

    def load(self, scenario: Scenario) -> None:
        """Build the scenario's arena in place of the one before."""
        if self._static:
            self._static.remove()
        self._static = StaticScene(self._scene, scenario)
        self._scenario = scenario
        self._taken: Counter[str] = Counter()

    def set_panel(self, sign: PanelSign) -> None:
        """Switch both panels."""
        self._arena.show(sign)

    @property
    def _arena(self) -> StaticScene:
        assert self._static, "load a scenario first"
        return self._static

    def pose_world_camera(self, camera_name: str, pose_world_robot: Pose3) -> Pose3:
        """Return where the camera truly is: mount errors of this scenario's robot included."""
        truth = self._scenario.robot_truth
        mount = self.rig.camera(camera_name)
        return pose_world_robot @ mount.pose_robot_camera(truth.camera_pitch_rad, truth.camera_roll_rad)

    def exposure(self, pose_world_robot: Pose3) -> float:
        """Return the exposure that the light on the floor before the robot leads to."""
        points = pose_world_robot.transform(np.column_stack([METERED, np.zeros(len(METERED))]))[:, :2]
        return exposure_for(self._scenario.look, self._arena.floor_irradiance(points))

    def exposed(self, camera_name: str, pose_world_robot: Pose3, exposure: float) -> NDArray[np.uint8]:
        """Return the noiseless picture (h, w, 4) uint8 at a given exposure."""
        component = self._cameras[camera_name]
        component.entity.set_pose(sapien_pose(self.pose_world_camera(camera_name, pose_world_robot)))
        self._scene.set_ambient_light([exposure] * 3)
        self._scene.update_render()
        component.take_picture()
        picture: NDArray[np.uint8] = component.get_picture("Color")
        return picture

    def raw(self, camera_name: str, pose_world_robot: Pose3) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Return the noiseless picture (h, w, 4) uint8 and the label ids (h, w) uint8."""
        colour = self.exposed(camera_name, pose_world_robot, self.exposure(pose_world_robot))
        return colour, self._label_ids(camera_name)

    def picture(self, camera_name: str, pose_world_robot: Pose3) -> bytes:
        """Return the delivered JPEG; the n-th of a scenario's camera always has the same noise."""
        index = self._taken[camera_name]
        self._taken[camera_name] += 1
        exposure = self.exposure(pose_world_robot)
        rgba = self.exposed(camera_name, pose_world_robot, exposure)
        return self._deliver(rgba, camera_name, index, exposure)

    def frame(self, index: int, camera_name: str, pose_world_robot: Pose3) -> Frame:
        """Return the delivered picture with its truth; noise is drawn by the frame's index."""
        exposure = self.exposure(pose_world_robot)
        rgba = self.exposed(camera_name, pose_world_robot, exposure)
        mount, pose_camera = self.rig.camera(camera_name), self.pose_world_camera(camera_name, pose_world_robot)
        look = self._scenario.look
        x, y, _ = pose_world_robot.translation_m
        yaw = float(np.arctan2(pose_world_robot.rotation[1, 0], pose_world_robot.rotation[0, 0]))
        return Frame(
            index=index,
            camera=camera_name,
            jpeg=self._deliver(rgba, camera_name, index, exposure),
            width_px=mount.width_px,
            height_px=mount.height_px,
            pose_world_robot=Pose2(x_m=float(x), y_m=float(y), yaw_rad=yaw),
            pose_world_camera=pose_camera,
            labels=labels_of(self._label_ids(camera_name), self._arena.targets, mount.camera(), pose_camera),
            conditions=Conditions(
                scenario=self._scenario.name,
                look_id=look.look_id,
                light_level=look.light_level,
                illuminance_lux=look.illuminance_lux,
                exposure=exposure,
                in_tunnel=self._in_tunnel(pose_camera.translation_m[:2]),
            ),
        )

    def _label_ids(self, camera_name: str) -> NDArray[np.uint8]:
        picture: NDArray[np.uint8] = self._cameras[camera_name].get_picture("Label")
        return np.asarray(cv2.extractChannel(picture, 0), np.uint8)

    def _deliver(self, rgba: NDArray[np.uint8], camera_name: str, index: int, exposure: float) -> bytes:
        share = min(1.0, exposure / EXPOSURE_DARK)
        noise_sd = NOISE_SD_BRIGHT + (NOISE_SD_DARK - NOISE_SD_BRIGHT) * share
        return deliver(rgba, noise_sd, stream(self._scenario.seed, "noise", camera_name, index))

    def _in_tunnel(self, point_world: NDArray[np.float64]) -> bool:
        scenario = self._scenario
        if scenario.tunnel is None:
            return False
        s0, s1 = tunnel_s_on_centre(scenario.course, scenario.tunnel)
        s, offset = road_centre(scenario.course).project(
            [point_world], around_s_m=(s0 + s1) / 2, window_m=(s1 - s0) / 2 + 1
        )
        return bool(s0 < s[0] < s1 and abs(offset[0]) < scenario.arena_spec.tunnel_clear_half_width_m)
