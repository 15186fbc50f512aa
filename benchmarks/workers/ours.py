"""Our renderer at work: ours.py WIDTH HEIGHT (raw | picture) [QUALITY [CAMERAS]]

raw: colours and label ids read back, through no lens, as the other renderers have none. picture: what a camera
delivers, lens, exposure, noise and JPEG included. A step is a frame of each camera.
"""

import sys

from arenas import arena, rig, stops
from turns import serve

from adc_bench.render.renderer import ArenaRenderer
from adc_bench.world.robot import Motion
from adc_bench.world.sensors import Lens

MOTION, STOP_S = Motion(v_mps=1.0), 1.7  # the poses are that far apart at this speed

(width_px, height_px), mode = map(int, sys.argv[1:3]), sys.argv[3]
cameras = int(sys.argv[5]) if len(sys.argv) > 5 else 1
sensor_rig = rig(width_px, height_px, cameras=cameras, lens=Lens(k1=0.0, k2=0.0) if mode == "raw" else None)
scenario = arena(0, sensor_rig)
poses = stops(scenario)
renderer = ArenaRenderer(sensor_rig, *sys.argv[4:5])
renderer.load(scenario)
time_s = 0.0


def step() -> None:
    global time_s
    pose, time_s = next(poses), time_s + STOP_S
    for mount in sensor_rig.cameras:
        if mode == "raw":
            renderer.raw(mount.name, pose)
        else:
            renderer.picture(mount.name, pose, time_s=time_s, motion=MOTION)


step()
serve(step, device=renderer.device_name)
