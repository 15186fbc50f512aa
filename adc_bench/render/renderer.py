"""The arena renderer: one scenario at a time, pictures from the rig's cameras, labels with them."""

from collections import Counter
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np
import sapien
from numpy.typing import NDArray

from adc_bench.api import SeenObject
from adc_bench.errors import UsageError
from adc_bench.geometry import Camera, Pose2, Pose3
from adc_bench.render.driver import choose_software_driver
from adc_bench.render.exposure import Metered, exposure_for, follow, seen_floor, settled, way_back
from adc_bench.render.labels import labels_of
from adc_bench.render.lane_lines import lane_lines_of
from adc_bench.render.pack_camera import PackView, Stage
from adc_bench.render.pack_scene import PackScene
from adc_bench.render.packs import PACKS
from adc_bench.render.pixel_classes import semantic_mask
from adc_bench.render.rig_camera import RigCamera, Taken, white_gains
from adc_bench.render.scene import FastScene
from adc_bench.render.semantic import objects_in_view
from adc_bench.render.targets import Target, targets_of
from adc_bench.render.view import View, use_arena_pack
from adc_bench.world.arena import road_centre, tunnel_s_on_centre
from adc_bench.world.categories import PanelSign
from adc_bench.world.frame import Conditions, Frame
from adc_bench.world.quality import Extra, Quality
from adc_bench.world.robot import Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import Imaging, SensorRig
from adc_bench.world.streams import stream

STILL = Motion()
FREE_IMAGING = Imaging()  # whose white balance the camera of `look_from` has
NOWHERE = Pose3(rotation=np.eye(3), translation_m=np.array([1e4, 1e4, 0.0]))  # for a robot that is not in the hall


@dataclass(frozen=True, kw_only=True, eq=False)
class Shot:
    """A picture that has been begun, with what it needs to be finished whatever the scene shows by then.

    Attributes:
        index: of the frame.
        number: of the picture's noise.
    """

    index: int
    number: int
    camera: RigCamera
    scenario: Scenario
    sign: PanelSign
    bodies: Mapping[str, Pose3]
    pose_world_robot: Pose3
    pose_world_camera: Pose3
    motion: Motion
    exposure: float

    def read(self) -> None:
        """Wait until the picture is drawn; its camera may then draw the next one."""
        self.camera.view.read()


class ArenaRenderer:
    """Renders scenarios on the software Vulkan driver; one a process, reused from scenario to scenario."""

    def __init__(self, rig: SensorRig, quality: Quality = "fast", extras: Collection[Extra] = ()) -> None:
        """`extras` is what frames have beside pictures and labels.

        Raises:
            MachineError: the software driver is not installed.
            InputError: a lens that cannot be.
        """
        choose_software_driver()
        use_arena_pack()
        self.rig = rig
        self._system = sapien.render.RenderSystem()
        self._scene = sapien.Scene([self._system])
        self._extras = frozenset(extras)
        self._stage = None if quality == "fast" else Stage(pack=PACKS[quality])
        self._cameras: Mapping[str, RigCamera] = {
            mount.name: RigCamera(self._view(mount.camera(), with_depth="depth" in extras), mount)
            for mount in rig.cameras
        }
        self._static: FastScene | None = None
        self._coming: FastScene | None = None
        self._staged: PackScene | None = None
        self._free: View | None = None

    @property
    def device_name(self) -> str:
        """The Vulkan device's name with its version."""
        return str(self._system.device.name)

    def load(self, scenario: Scenario) -> None:
        """Build the scenario's arena in place of the one before; auto-exposure and noise start anew."""
        if self._static:
            self._each(lambda arena: arena.remove())
        self._static, self._coming = self._begun(scenario), None
        self._static.enter()
        self._staged = PackScene(self._stage, scenario) if self._stage else None
        self._scenario = scenario
        self._taken: Counter[str] = Counter()
        self._metered: dict[str, Metered] = {}

    def prepare(self, scenario: Scenario) -> None:
        """Build one more piece, in some 10 ms, of the arena that is to be loaded next: there is time while a picture
        is drawn.
        """
        self._coming = self._begun(scenario)
        self._coming.build()

    def _begun(self, scenario: Scenario) -> FastScene:
        if self._coming and self._coming.scenario is scenario:
            return self._coming
        return FastScene(self._scene, scenario, at_once=False)

    def set_panel(self, sign: PanelSign) -> None:
        """Switch both panels."""
        if sign != self._arena.sign:
            self._each(lambda arena: arena.show(sign))

    def place(self, bodies: Mapping[str, Pose3], torn: Collection[str] = ()) -> None:
        """Move bodies to these poses and hide torn tapes; only what has really moved costs time."""
        self._each(lambda arena: arena.place(bodies, torn))

    def _view(self, camera: Camera, *, with_depth: bool = False) -> View:
        if self._stage:
            return PackView(self._scene, self._stage, camera, with_depth=with_depth)
        return View(self._scene, camera, with_depth=with_depth)

    def _each(self, do: Callable[[FastScene | PackScene], None]) -> None:
        """Do something to our own pack's arena, and to that of the quality's pack if it has another."""
        do(self._arena)
        if self._staged:
            do(self._staged)

    @property
    def _arena(self) -> FastScene:
        assert self._static, "load a scenario first"
        return self._static

    @property
    def targets(self) -> tuple[Target, ...]:
        """What is labelled, with the sign that the panels show now."""
        return self._arena.targets

    def pose_world_camera(self, camera_name: str, pose_world_robot: Pose3) -> Pose3:
        """Return where the camera truly is: mount errors of this scenario's robot and its body's tilt included."""
        truth = self._scenario.robot_truth
        mount = self.rig.camera(camera_name)
        return pose_world_robot @ mount.pose_robot_camera(truth.camera_pitch_rad, truth.camera_roll_rad)

    def exposure(self, pose_world_robot: Pose3) -> float:
        """Return the exposure that the light on the floor before the robot leads to in the end."""
        (settled_now,) = settled(self._scenario.look, self._arena.floor_irradiance, [pose_world_robot])
        return settled_now

    def exposure_on_the_way(self, camera_name: str, pose_world_robot: Pose3, motion: Motion = STILL) -> float:
        """Return the exposure of a camera on a robot that came to a pose at this motion."""
        lag_s, now = self.rig.camera(camera_name).imaging.exposure_lag_s, None
        times_s, poses = zip(*way_back(pose_world_robot, motion, lag_s), strict=True)
        wanted = settled(self._scenario.look, self._arena.floor_irradiance, poses)
        for time_s, exposure in zip(times_s, wanted, strict=True):
            now = follow(now, exposure, time_s, lag_s)
        assert now
        return now.exposure

    def exposed(self, camera_name: str, pose_world_robot: Pose3, exposure: float) -> NDArray[np.uint8]:
        """Return the noiseless sharp picture (h, w, 4) uint8 at a given exposure, behind the lens."""
        camera = self._cameras[camera_name]
        self._draw(camera, pose_world_robot, exposure)
        camera.view.read()
        return camera.view.colour()

    def raw(self, camera_name: str, pose_world_robot: Pose3) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Return the noiseless sharp picture (h, w, 4) uint8 and the label ids (h, w) uint8, exposure settled."""
        colour = self.exposed(camera_name, pose_world_robot, self.exposure(pose_world_robot))
        return colour, self._cameras[camera_name].view.label_ids()

    def picture(self, camera_name: str, pose_world_robot: Pose3, *, time_s: float, motion: Motion = STILL) -> bytes:
        """Return the delivered file of a drive's picture at mid-exposure `time_s`, when the robot has this motion.

        The n-th of a scenario's camera always has the same noise. The camera's exposure follows from picture to
        picture; the first has settled.
        """
        shot = self.shoot_next(0, camera_name, pose_world_robot, time_s=time_s, motion=motion)
        shot.read()
        return _developed(shot).file

    def drive_frame(
        self, index: int, camera_name: str, pose_world_robot: Pose3, *, time_s: float, motion: Motion = STILL
    ) -> Frame:
        """Return what `picture` delivers, byte for byte, with its truth; `index` only numbers the frame."""
        shot = self.shoot_next(index, camera_name, pose_world_robot, time_s=time_s, motion=motion)
        shot.read()
        return self.finish(shot)

    def frame(self, index: int, camera_name: str, pose_world_robot: Pose3, motion: Motion = STILL) -> Frame:
        """Return the delivered picture with its truth; noise is drawn by the frame's index.

        The exposure is that of a robot which came here at this motion.
        """
        exposure = self.exposure_on_the_way(camera_name, pose_world_robot, motion)
        shot = self.shoot(index, camera_name, pose_world_robot, exposure, motion)
        shot.read()
        return self.finish(shot)

    def shoot(
        self, index: int, camera_name: str, pose_world_robot: Pose3, exposure: float, motion: Motion = STILL
    ) -> Shot:
        """Begin a `frame`. While it is drawn there is time to `finish` the shot that was read before, and to work out
        the next one's `exposure_on_the_way`.
        """
        return self._shoot((index, index), self._cameras[camera_name], pose_world_robot, exposure, motion)

    def shoot_next(
        self, index: int, camera_name: str, pose_world_robot: Pose3, *, time_s: float, motion: Motion = STILL
    ) -> Shot:
        """Begin a `drive_frame`, as `shoot` a `frame`: the camera's exposure follows from the picture before."""
        camera, wanted = self._cameras[camera_name], self.exposure(pose_world_robot)
        lag_s = camera.mount.imaging.exposure_lag_s
        now = self._metered[camera_name] = follow(self._metered.get(camera_name), wanted, time_s, lag_s)
        number = self._taken[camera_name]
        self._taken[camera_name] += 1
        return self._shoot((index, number), camera, pose_world_robot, now.exposure, motion)

    def objects_in_view(self, camera_name: str, pose_world_robot: Pose3) -> tuple[SeenObject, ...]:
        """Return what the semantic camera says: the labelled objects that the camera has in view, and where they are.

        Raises:
            UsageError: the rig has no semantic camera.
        """
        spec, view = self.rig.semantic, self._cameras[camera_name].view
        if spec is None:
            raise UsageError(
                where="the renderer's sensor rig",
                found="no semantic camera",
                wanted="SensorRig(semantic=SemanticCameraSpec(...))",
                todo="load the arena with such a rig, or look for objects in the pictures",
            )
        pose_world_camera = self._draw(self._cameras[camera_name], pose_world_robot, 1.0)
        view.read()
        labels = labels_of(view.label_ids(), self.targets, view.camera, pose_world_camera)
        return objects_in_view(labels, self.targets, pose_world_robot, spec.range_max_m)

    def look_from(
        self, camera: Camera, pose_world_camera: Pose3, pose_world_robot: Pose3 | None = None
    ) -> NDArray[np.uint8]:
        """Return what an ideal camera anywhere sees, rgb (h, w, 3) uint8; its exposure fits the floor in view.

        The robot is seen at `pose_world_robot`, if that is given.
        """
        if self._free is None or self._free.camera != camera:
            if self._free:
                self._free.remove()
            self._free = self._view(camera)
        floor = seen_floor(camera, pose_world_camera)
        exposure = exposure_for(self._scenario.look, float(self._arena.floor_irradiance(floor).mean()))
        robot, visible = pose_world_robot or NOWHERE, pose_world_robot is not None
        self._each(lambda arena: arena.place_robot(robot, visible=visible))
        self._free.take(pose_world_camera, exposure * white_gains(self._scenario.look, FREE_IMAGING))
        self._free.read()
        return np.ascontiguousarray(self._free.colour()[..., :3])

    def _draw(self, camera: RigCamera, pose_world_robot: Pose3, exposure: float) -> Pose3:
        """Begin to draw the scene with the robot there; return where the camera is."""
        self._each(lambda arena: arena.place_robot(pose_world_robot))
        pose_world_camera = self.pose_world_camera(camera.mount.name, pose_world_robot)
        camera.expose(pose_world_camera, self._scenario.look, exposure)
        return pose_world_camera

    def _shoot(
        self, numbers: tuple[int, int], camera: RigCamera, pose_world_robot: Pose3, exposure: float, motion: Motion
    ) -> Shot:
        """Begin a picture; its numbers are the frame's and the noise's."""
        return Shot(
            index=numbers[0],
            number=numbers[1],
            camera=camera,
            scenario=self._scenario,
            sign=self._arena.sign,
            bodies=dict(self._arena.body_poses),
            pose_world_robot=pose_world_robot,
            pose_world_camera=self._draw(camera, pose_world_robot, exposure),
            motion=motion,
            exposure=exposure,
        )

    def finish(self, shot: Shot) -> Frame:
        """Return the picture of a shot that has been read, with its truth."""
        taken, scenario, camera = _developed(shot), shot.scenario, shot.camera
        look, mount, pose_camera = scenario.look, camera.mount, shot.pose_world_camera
        targets, ids = targets_of(scenario, shot.sign, shot.bodies), camera.view.label_ids()
        x, y, _ = shot.pose_world_robot.translation_m
        rotation = shot.pose_world_robot.rotation
        yaw = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
        return Frame(
            index=shot.index,
            camera=mount.name,
            jpeg=taken.file,
            width_px=mount.width_px,
            height_px=mount.height_px,
            pose_world_robot=Pose2(x_m=float(x), y_m=float(y), yaw_rad=yaw),
            pose_world_camera=pose_camera,
            motion=shot.motion,
            lane_lines=lane_lines_of(ids, scenario.course, camera.view.camera, pose_camera),
            labels=labels_of(ids, targets, camera.view.camera, pose_camera),
            conditions=Conditions(
                scenario=scenario.name,
                look_id=look.look_id,
                light_level=look.light_level,
                illuminance_lux=look.illuminance_lux,
                exposure=taken.exposure,
                shutter_s=taken.shutter_s,
                blur_px=taken.blur_px,
                in_tunnel=_in_tunnel(scenario, pose_camera.translation_m[:2]),
            ),
            depth_m=camera.view.depth_m() if "depth" in self._extras else None,
            semantic=semantic_mask(ids, targets, camera.view.camera, pose_camera, scenario.course_spec)
            if "semantic" in self._extras
            else None,
        )


def _developed(shot: Shot) -> Taken:
    noise = stream(shot.scenario.seed, "noise", shot.camera.mount.name, shot.number)
    poses = shot.pose_world_robot, shot.pose_world_camera
    return shot.camera.develop(poses, shot.exposure, shot.motion, noise)


def _in_tunnel(scenario: Scenario, point_world: NDArray[np.float64]) -> bool:
    if scenario.tunnel is None:
        return False
    s0, s1 = tunnel_s_on_centre(scenario.course, scenario.tunnel)
    s, offset = road_centre(scenario.course).project(
        [point_world], around_s_m=(s0 + s1) / 2, window_m=(s1 - s0) / 2 + 1
    )
    return bool(s0 < s[0] < s1 and abs(offset[0]) < scenario.arena_spec.tunnel_clear_half_width_m)
