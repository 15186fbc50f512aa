"""Our renderer at work: ours.py WIDTH HEIGHT (raw | picture) [QUALITY [CAMERAS]]

raw: colours and label ids read back, through no lens, as the other renderers have none. picture: what a camera
delivers, lens, exposure, noise and JPEG included. A step is a frame of each camera.
"""

import sys

from arenas import arena, rig, stops
from turns import serve

from adc_bench.render.renderer import ArenaRenderer
from adc_bench.world.sensors import Lens

(width_px, height_px), mode = map(int, sys.argv[1:3]), sys.argv[3]
cameras = int(sys.argv[5]) if len(sys.argv) > 5 else 1
sensor_rig = rig(width_px, height_px, cameras=cameras, lens=Lens(k1=0.0, k2=0.0) if mode == "raw" else None)
scenario = arena(0, sensor_rig)
poses = stops(scenario)
renderer = ArenaRenderer(sensor_rig, *sys.argv[4:5])
renderer.load(scenario)
take = renderer.raw if mode == "raw" else renderer.picture


def step() -> None:
    pose = next(poses)
    for mount in sensor_rig.cameras:
        take(mount.name, pose)


step()
serve(step, device=renderer.device_name)
