"""Our renderer at work: ours.py WIDTH HEIGHT (raw | picture)

raw: colours and label ids read back. picture: what a camera delivers, lens, exposure, noise and JPEG included.
"""

import sys

from arenas import arena, rig, stops
from turns import serve

from adc_bench.render.renderer import ArenaRenderer
from adc_bench.world.sensors import Lens

width_px, height_px = map(int, sys.argv[1:3])
lens = Lens(k1=0.0, k2=0.0) if sys.argv[3] == "raw" else None  # the other renderers have no lens either
sensor_rig = rig(width_px, height_px, lens=lens)
scenario = arena(0, sensor_rig)
poses = stops(scenario)
renderer = ArenaRenderer(sensor_rig)
renderer.load(scenario)
take = renderer.raw if sys.argv[3] == "raw" else renderer.picture


def step() -> None:
    take("road", next(poses))


step()
serve(step, device=renderer.device_name)
