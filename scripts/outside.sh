#!/bin/sh
# Makes the environments of the readers that tests/proofs/test_outside.py lets read the exports: .peers/evo (GPL),
# .peers/ultralytics (AGPL) and .peers/webdataset. None is a part of adc-bench nor comes near .venv. What is there is
# left alone. The last two take torch, OpenCV and the like from .venv, and of their own what tests/proofs/outside lists.
set -eu
cd "$(dirname "$0")/.."
packages='import sysconfig; print(sysconfig.get_path("purelib"))'

for reader in evo ultralytics webdataset; do
  wanted=tests/proofs/outside/$reader.txt
  cmp -s "$wanted" ".peers/$reader/installed.txt" && continue
  echo "outside: installing $reader into .peers/$reader"
  .venv/bin/python -m venv --clear ".peers/$reader"
  if [ $reader = evo ]; then
    ".peers/$reader/bin/python" -m pip install --quiet -r "$wanted"
  else
    .venv/bin/python -c "$packages" >"$(".peers/$reader/bin/python" -c "$packages")/venv.pth"
    ".peers/$reader/bin/python" -m pip install --quiet --no-deps -r "$wanted"
  fi
  cp "$wanted" ".peers/$reader/installed.txt"
done
