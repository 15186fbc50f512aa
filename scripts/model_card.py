"""The card of the weights that ship with the package: what they are, what they learned from, what they are worth.

Usage: model_card.py WEIGHTS --run RUN --recipe FILE --train DIR --val DIR --test DIR --report FILE

Writes WEIGHTS' card beside them, as Markdown. RUN is the folder of the training. The report is what
`adc-bench evaluate detector WEIGHTS --data TEST --out FILE` writes.
"""

import argparse
import hashlib
import sys
import textwrap
from pathlib import Path

import msgspec

from adc_bench.dataset import FrameDataset
from adc_bench.dataset.layout import write_file
from adc_bench.detector.evaluation import DetectionReport, EvaluatedWeights
from adc_bench.detector.evaluation.table import markdown_lines
from adc_bench.detector.evaluation.tables import tables
from adc_bench.detector.weights import read_weights

TEMPLATE = """\
# Detector `{name}`

Finds the crosswalk, what the panels show, vertical signs, boxes and cones of the ADC course in pictures of the robot's
cameras, with the corners of crosswalk, panels and signs. {parameters:,} parameters, {size:.2f} MB, architecture
`{architecture}`. SHA-256: `{sha256}`

## What it learned from

Synthetic pictures alone, of the public recipe. Nothing was taken from elsewhere, no weights to start from either.

| set | for | pictures | split (sha256) | shards (sha256) |
|---|---|---|---|---|
{data}

`scripts/weights.sh` renders the pictures, trains by the recipe `{recipe}`, evaluates, and writes this card. The weights
are the best of {epochs} epochs by mAP50-95 on val ({val_map:.3f} there).

```toml
{recipe_text}
```

## What it is worth

On the test split, whose looks, drawings and seeds it never saw:

```
adc-bench evaluate detector {name}.safetensors --data DIR --out FILE --page FILE
```

{figures}

The driver believes detections from a score of {threshold:g} on. On val the rule says {val_threshold:g}: of 0.05, 0.10
to 0.95 the threshold with the best F1 over all categories, or the least one above it at which no crosswalk is found on
a picture that shows none.

## Limits

* It knows the looks of the train split: another course, other signs, other cameras or another lens want other weights.
* It was never shown a photograph. What it is worth on a real course is not known.
* A score is no probability: see the calibration.
* Small and far objects are the hardest: see the rows by size and by distance.
* Its pictures are {camera}, as the robot's cameras deliver them. It takes others; its figures are not these then.

Licence: Apache-2.0, as the program.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("weights", type=Path)
    for name in ("run", "recipe", "train", "val", "test", "report"):
        parser.add_argument(f"--{name}", type=Path, required=True)
    options = parser.parse_args()
    report = msgspec.json.decode(options.report.read_bytes(), type=EvaluatedWeights)
    sha256, test = hashlib.sha256(options.weights.read_bytes()).hexdigest(), FrameDataset(options.test)
    if (report.weights_sha256, report.shards_sha256) != (sha256, test.manifest.shards_sha256):
        sys.exit(f"error: {options.report} is the report of other weights or of other pictures")
    write_file(options.weights.with_suffix(".md"), card(options, report, sha256, test).encode())


def card(options: argparse.Namespace, report: EvaluatedWeights, sha256: str, test: FrameDataset) -> str:
    tensors, note = read_weights(options.weights)
    on_val = msgspec.json.decode((options.run / "metrics.json").read_bytes(), type=DetectionReport)
    train, val = FrameDataset(options.train), FrameDataset(options.val)
    return TEMPLATE.format(
        name=options.weights.stem,
        parameters=sum(tensor.size for tensor in tensors.values()),
        size=options.weights.stat().st_size / 1e6,
        architecture=note.architecture,
        sha256=sha256,
        data="\n".join(map(row, ("learning", "choosing", "the figures below"), (train, val, test))),
        recipe=options.recipe.stem,
        epochs=len((options.run / "log.jsonl").read_text(encoding="utf-8").splitlines()),
        val_map=on_val.overall.map,
        recipe_text=options.recipe.read_text(encoding="utf-8").strip(),
        figures="\n\n".join(markdown(report)),
        threshold=report.operating.threshold,
        val_threshold=on_val.operating.threshold_by_rule,
        camera=f"{test.width_px}x{test.height_px}",
    )


def row(use: str, dataset: FrameDataset) -> str:
    manifest = dataset.manifest
    return (
        f"| {manifest.split.name} | {use} | {len(dataset):,} | `{manifest.split_sha256}` | `{manifest.shards_sha256}` |"
    )


def markdown(report: DetectionReport) -> list[str]:
    return [
        "\n".join("\n".join(textwrap.wrap(line, 120)) if not line.startswith("|") else line for line in lines)
        for lines in map(markdown_lines, tables(report))
    ]


if __name__ == "__main__":
    main()
