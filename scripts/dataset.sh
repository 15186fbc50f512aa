#!/bin/sh
# dataset.sh [FOLDER]: the public dataset, as many frames and drives as splits/{train,val,test}.toml say, checked against
# each other, counted, and shown on pages (default: build/dataset). Every `run` is a command that works by itself. Run
# again after a break, it goes on where it stopped.
set -eu
cd "$(dirname "$0")/.."
PATH="$PWD/.venv/bin:$PATH"
out=${1:-build/dataset}
started=$(date +%s)

run() {
  echo
  echo "\$ $*"
  "$@"
}

mkdir -p "$out/pages"
against=
for split in train val test; do
  run adc-bench render --split $split --out "$out/$split"
  run adc-bench render --split $split --kind drives --out "$out/drives-$split"
  for name in $split drives-$split; do
    run adc-bench dataset check "$out/$name" $against
    run adc-bench dataset stats "$out/$name" --out "$out/pages/$name" >"$out/pages/$name.txt"
    run adc-bench dataset preview "$out/$name" --out "$out/pages/$name/preview.html"
  done
  against="$against --against $out/$split --against $out/drives-$split"
done

echo
for name in train val test drives-train drives-val drives-test; do
  echo "$(du -sh "$out/$name" | cut -f1)	$(grep -m 1 " pictures of " "$out/pages/$name.txt")"
done
took=$(($(date +%s) - started))
echo "$(du -sh "$out" | cut -f1)	$out in $((took / 60)) min $((took % 60)) s"
