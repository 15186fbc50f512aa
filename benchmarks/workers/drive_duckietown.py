"""gym-duckietown's closed loop: drive_duckietown.py WIDTH HEIGHT MAP

A step is one `env.step` (1/30 s), steered by its own true lane position so that it stays on the road. No distortion, no
domain randomisation, as fast as it goes.
"""

import sys

from turns import serve

import gym_duckietown  # isort: skip  # sets pyglet headless before anything imports it
from gym_duckietown.envs import DuckietownEnv
from gym_duckietown.simulator import NotInLane

SPEED, GAIN_ANGLE, GAIN_OFFSET = 0.35, 10.0, 5.0

width_px, height_px = map(int, sys.argv[1:3])
env = DuckietownEnv(
    map_name=sys.argv[3],
    camera_width=width_px,
    camera_height=height_px,
    seed=1,
    max_steps=10**9,
    domain_rand=False,
    distortion=False,
)
env.reset()


def steering() -> float:
    try:
        lane = env.get_lane_pos2(env.cur_pos, env.cur_angle)
    except NotInLane:
        return 0.0
    return GAIN_ANGLE * lane.angle_rad + GAIN_OFFSET * lane.dist


def step():
    picture, _, done, _ = env.step([SPEED, steering()])
    if done:
        env.reset()
    return picture


assert step().shape == (height_px, width_px, 3)
serve(step, version=gym_duckietown.__version__)
