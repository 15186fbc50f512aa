#!/bin/sh
# Runs every measurement in benchmarks/, one after the other, and prints the README's figures; about half an hour on
# two cores, which should have nothing else to do. The peers' environments are made first (PEERS=no leaves them out).
set -eu
cd "$(dirname "$0")/.."
[ "${PEERS:-yes}" = no ] || sh scripts/peers.sh

for benchmark in renderers qualities switches closed_loop memory render read drive isolation odometry detector; do
  echo
  echo "## $benchmark"
  echo
  .venv/bin/python "benchmarks/$benchmark.py"
done
