"""A shader pack of SAPIEN's own on our meshes and textures: sapien_pack.py WIDTH HEIGHT (trivial | default)

`default` gets two lights with shadows, as its user would set them up. Colours (uint8) and segmentation are read back.
"""

import sys

import sapien
from arenas import arena, rig, stops
from turns import serve

from adc_bench.render.arena_parts import ArenaParts
from adc_bench.render.driver import choose_software_driver
from adc_bench.render.moving import moving_bodies, tape_part
from adc_bench.render.pack_surfaces import reflecting
from adc_bench.render.parts import Part
from adc_bench.render.scene import body_pose, entity_of, sapien_pose
from adc_bench.render.view import FAR_M, NEAR_M
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import Lens

width_px, height_px, pack = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
choose_software_driver()
sapien.render.set_camera_shader_dir(pack)
sapien.render.set_picture_format("Color", "r8g8b8a8unorm")
scene = sapien.Scene([sapien.render.RenderSystem()])


def add(part: Part) -> sapien.Entity:
    entity = entity_of(part.mesh, reflecting(part))
    scene.add_entity(entity)
    return entity


def build(scenario: Scenario) -> None:
    """Everything that our own renderer draws but the robot, which its camera does not see."""
    bodies = {body.name: body for body in moving_bodies(scenario)}
    for part in ArenaParts.of(scenario).standing():
        add(part)
    for body in bodies.values():
        add(body.part).set_pose(body_pose(body.start))
    for tape in scenario.tapes:
        add(tape_part(tape, {name: body.start for name, body in bodies.items()}))


sensor_rig = rig(width_px, height_px, lens=Lens(k1=0.0, k2=0.0))
scenario = arena(0, sensor_rig)
build(scenario)
if pack == "default":
    scene.set_ambient_light([0.2, 0.2, 0.2])
    for x_m, y_m in ((-4.0, -2.0), (4.0, 2.0)):
        scene.add_spot_light([x_m, y_m, 3.8], [0.0, 0.0, -1.0], 2.2, 2.6, [60.0, 60.0, 60.0], shadow=True)

mount, intrinsics = sensor_rig.cameras[0], sensor_rig.cameras[0].camera()
camera = sapien.render.RenderCameraComponent(width_px, height_px)
camera.set_perspective_parameters(
    NEAR_M, FAR_M, intrinsics.fx_px, intrinsics.fy_px, intrinsics.cx_px, intrinsics.cy_px, 0.0
)
entity = sapien.Entity()
entity.add_component(camera)
scene.add_entity(entity)
poses = stops(scenario)


def step() -> None:
    entity.set_pose(sapien_pose(next(poses) @ mount.pose_robot_camera()))
    scene.update_render()
    camera.take_picture()
    camera.get_picture("Color")
    camera.get_picture("Segmentation")


step()
serve(step)
