#!/bin/sh
# Makes the environments of the simulators that benchmarks/ measures beside ours: .peers/mujoco and .peers/duckietown.
# What is already there is left alone. Each needs EGL without a screen, that is Mesa's software OpenGL; as root:
#   apt-get install --no-install-recommends libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libglu1-mesa
# gym-duckietown (2021) runs under Python 3.11 with pyglet 1.5, gym 0.23 and numpy 1.23.
set -eu
cd "$(dirname "$0")/.."

for peer in mujoco duckietown; do
  wanted=benchmarks/workers/$peer.txt
  cmp -s "$wanted" ".peers/$peer/installed.txt" && continue
  echo "peers: installing $peer into .peers/$peer"
  "${PYTHON:-python3.11}" -m venv --clear ".peers/$peer"
  ".peers/$peer/bin/python" -m pip install --quiet -r "$wanted"
  cp "$wanted" ".peers/$peer/installed.txt"
done
