#!/bin/sh
# demo.sh FOLDER: the whole job once, small enough for two cores and ten minutes. Every `run` is a command that
# works by itself. Run again after a break, it goes on where it stopped; after a change of the program, it starts afresh.
set -eu
cd "$(dirname "$0")/.."
PATH="$PWD/.venv/bin:$PATH"
demo=$1
started=$(date +%s)

run() {
  echo
  echo "\$ $*"
  "$@"
}

made_by=$(find adc_bench splits scripts/demo.sh -type f ! -name '*.pyc' | LC_ALL=C sort | xargs sha256sum | sha256sum)
[ "$(cat "$demo/made-by" 2>/dev/null)" = "$made_by" ] || rm -rf "$demo"
mkdir -p "$demo"
echo "$made_by" >"$demo/made-by"
run adc-bench render --split train --frames 2400 --out "$demo/train"
run adc-bench render --split val --frames 400 --out "$demo/val"
resume=--resume
[ -e "$demo/detector/last.safetensors" ] || { rm -rf "$demo/detector" && resume=; }
run adc-bench train-detector --train "$demo/train" --val "$demo/val" --out "$demo/detector" \
  --config demo $resume
run adc-bench evaluate submission thesis --suite d1 --workers 2 --out "$demo/drive" \
  --set "weights=$demo/detector/weights.safetensors"
rm -rf "$demo/leaderboard"
run adc-bench leaderboard add "$demo/drive" --leaderboard "$demo/leaderboard" --unranked
run adc-bench leaderboard export --leaderboard "$demo/leaderboard" --out "$demo/leaderboard.json"
run adc-bench leaderboard site --leaderboard "$demo/leaderboard" --out "$demo/site"

echo
python scripts/demo_summary.py "$demo" $(($(date +%s) - started))
