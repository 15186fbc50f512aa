#!/bin/sh
# Trains the weights that ship with the package, from scratch, by a recorded recipe.
# The pictures and the run stay in build/weights, so that a broken run goes on where it stopped.
set -eu
cd "$(dirname "$0")/.."
PATH="$PWD/.venv/bin:$PATH"
work=build/weights

adc-bench render --split train --frames 8000 --out $work/train
adc-bench render --split val --frames 1000 --out $work/val
resume=--resume
[ -e $work/run/last.safetensors ] || { rm -rf $work/run && resume=; }
adc-bench train-detector --train $work/train --val $work/val --out $work/run --device cpu --config n $resume
weights=adc_bench/detector/weights/n.safetensors
cp $work/run/weights.safetensors $weights

adc-bench render --split test --frames 2000 --out $work/test
adc-bench evaluate detector $weights --data $work/test --out $work/test.json --page $work/test.html
python scripts/model_card.py $weights --run $work/run --recipe adc_bench/detector/training/recipes/n.toml \
  --train $work/train --val $work/val --test $work/test --report $work/test.json
