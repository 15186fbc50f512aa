#!/bin/sh
# Runs every measurement in benchmarks/, one after the other, and prints the README's figures.
set -eu
cd "$(dirname "$0")/.."
for benchmark in benchmarks/*.py; do
  echo
  echo "## $benchmark"
  .venv/bin/python "$benchmark"
done
