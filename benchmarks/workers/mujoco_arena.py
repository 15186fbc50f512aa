"""MuJoCo on the arena that scene_file.py wrote: mujoco_arena.py WIDTH HEIGHT FOLDER (equal | defaults)

Needs MUJOCO_GL=egl. Two lights cast shadows. equal: shadow maps as large as SAPIEN's, no multisampling, as for the
others; defaults: four times as many texels, four samples a pixel. A frame is two draws: colours, then segmentation.
Cones are cylinders, and there is no ceiling, which would shade all.
"""

import json
import sys
from itertools import cycle
from pathlib import Path

import mujoco
import numpy as np
from turns import serve

width_px, height_px, folder = int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
scene = json.loads((folder / "scene.json").read_text())
KINDS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "cone": mujoco.mjtGeom.mjGEOM_CYLINDER,
}


def quaternion(rotation) -> np.ndarray:
    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, np.array(rotation, float))
    return found


def build() -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width_px, height_px
    if sys.argv[4] == "equal":
        spec.visual.quality.shadowsize, spec.visual.quality.offsamples = 2048, 0
    spec.visual.headlight.active = 0
    length, width, _ = scene["hall_m"]
    spec.stat.extent, spec.stat.center = length, [0, 0, 1]
    spec.visual.map.znear, spec.visual.map.zfar = 0.05 / length, 40 / length
    x0, y0, x1, y1 = scene["floor_bounds_m"]
    spec.add_texture(name="floor", type=mujoco.mjtTexture.mjTEXTURE_2D, file=str(folder / "floor.png"))
    floor = spec.add_material(name="floor", texrepeat=[1, 1])
    floor.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    world, plane = spec.worldbody, mujoco.mjtGeom.mjGEOM_PLANE
    middle, half = [(x0 + x1) / 2, (y0 + y1) / 2], [(x1 - x0) / 2, (y1 - y0) / 2]
    world.add_geom(type=plane, size=[*half, 0.1], pos=[*middle, 0.001], material="floor")
    world.add_geom(type=plane, size=[length, width, 0.1], rgba=[0.25, 0.25, 0.25, 1])
    for shape in scene["shapes"]:
        x, y, z = shape["size_m"]
        world.add_geom(
            type=KINDS[shape["shape"]],
            size=[x / 2, y / 2, z / 2] if shape["shape"] == "box" else [x / 2, z / 2, 0],
            pos=shape["position_m"],
            quat=quaternion(shape["rotation"]),
            rgba=[*shape["albedo"], 1],
        )
    directional, spot = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, mujoco.mjtLightType.mjLIGHT_SPOT
    for kind, place, towards in ((directional, [-4, -3, 3.5], [0.4, 0.3, -1]), (spot, [0, 0, 3.5], [0, 0, -1])):
        world.add_light(
            type=kind, pos=place, dir=towards, castshadow=True, cutoff=70, ambient=[0.3] * 3, diffuse=[0.5] * 3
        )
    world.add_camera(name="road", fovy=float(np.degrees(scene["fovy_rad"])))
    return spec.compile()


model = build()
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
renderer = mujoco.Renderer(model, height_px, width_px, max_geom=len(scene["shapes"]) + 100)
poses = cycle(
    (np.array(camera["position_m"]), (np.array(camera["optical"]).reshape(3, 3) * [1, -1, -1]).ravel())
    for camera in scene["cameras"]
)


def step() -> np.ndarray:
    data.cam_xpos[0], data.cam_xmat[0] = next(poses)
    renderer.update_scene(data, "road")
    rgb = renderer.render()
    renderer.enable_segmentation_rendering()
    renderer.render()
    renderer.disable_segmentation_rendering()
    return rgb


np.save(folder / "mujoco.npy", step())
serve(step, version=mujoco.__version__)
