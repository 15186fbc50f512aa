#!/bin/sh
# Makes the environments of the readers that tests/proofs/test_outside.py lets read the exports: .peers/evo (GPL),
# .peers/ultralytics (AGPL) and .peers/webdataset; and .peers/s3, a server that speaks S3 and fsspec's driver for it, for
# tests/proofs/test_object_store.py; and .peers/filterpy (MIT), whose filter tests/proofs/test_outside_filter.py runs.
# None is a part of adc-bench nor comes near .venv. What is there is left alone. All but evo take torch, OpenCV and the
# like from .venv, and of their own what tests/proofs/outside lists.
set -eu
cd "$(dirname "$0")/.."
packages='import sysconfig; print(sysconfig.get_path("purelib"))'

for reader in evo ultralytics webdataset s3 filterpy; do
  wanted=tests/proofs/outside/$reader.txt
  cmp -s "$wanted" ".peers/$reader/installed.txt" && continue
  echo "outside: installing $reader into .peers/$reader"
  .venv/bin/python -m venv --clear ".peers/$reader"
  case $reader in evo | s3) alone= ;; *) alone=--no-deps ;; esac
  ".peers/$reader/bin/python" -m pip install --quiet $alone -r "$wanted"
  [ $reader = evo ] || .venv/bin/python -c "$packages" >"$(".peers/$reader/bin/python" -c "$packages")/venv.pth"
  cp "$wanted" ".peers/$reader/installed.txt"
done
