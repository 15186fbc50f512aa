#!/bin/sh
# Makes the environments of the readers that tests/proofs/test_outside.py lets read the exports: .peers/evo (GPL) and
# .peers/ultralytics (AGPL). Neither is a part of adc-bench nor comes near .venv. What is there is left alone.
# Ultralytics takes torch, OpenCV and the like from .venv, and of its own only what tests/proofs/outside lists.
set -eu
cd "$(dirname "$0")/.."

for reader in evo ultralytics; do
  wanted=tests/proofs/outside/$reader.txt
  cmp -s "$wanted" ".peers/$reader/installed.txt" && continue
  echo "outside: installing $reader into .peers/$reader"
  .venv/bin/python -m venv --clear ".peers/$reader"
  if [ $reader = ultralytics ]; then
    .venv/bin/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))' \
      >"$(".peers/$reader/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/venv.pth"
    ".peers/$reader/bin/python" -m pip install --quiet --no-deps -r "$wanted"
  else
    ".peers/$reader/bin/python" -m pip install --quiet -r "$wanted"
  fi
  cp "$wanted" ".peers/$reader/installed.txt"
done
