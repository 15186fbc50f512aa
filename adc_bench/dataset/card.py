"""The dataset's card: its README.md."""

from adc_bench.dataset.layout import CARD_PICTURE, COCO, Manifest, Summary

TEMPLATE = """\
# adc-bench dataset: split `{split}`, {kind}

{what} of the ADC figure-eight course, taken through the robot's cameras, rendered and labelled by adc-bench {version}.
Every picture, label and pose is synthetic.

![Pictures from all over the dataset, with their boxes]({picture})

| | |
|---|---|
{totals}

| camera | pictures |
|---|---|
{cameras}

| light level | pictures |
|---|---|
{light_levels}
| (in the tunnel, at any level) | {tunnel_frames} |

| category | boxes |
|---|---|
{boxes}
| (ignore regions) | {ignored} |

## Files
- `dataset.toml`: what made it: the split and its digest, cameras, package versions, size and digest of every file.
- `shard-*.h5`: {shards}
- {coco}
- {poses}

Groups, columns and units are in the program's `docs/dataset.md`, what each label means in `docs/labels.md`. Metres and
radians; world: origin midway between the loops, x along the long axis, z up; camera: x right, y down, z forward;
pixel centres lie at whole numbers plus one half. What is too small or too hidden is an ignore region.

## Make it again, check it, look at it
```
{command}
adc-bench dataset check DIR
adc-bench dataset stats DIR
adc-bench dataset preview DIR --out page.html
```
The same versions make the same bytes. Split (sha256): `{sha256}`{salt}
Renderer: {renderer}; {packages}.

## Licence
Apache-2.0, as the program: everything here is its output, nothing is taken from elsewhere. Cite adc-bench {version}.
"""


def card(manifest: Manifest, summary: Summary) -> str:
    """Return the text of the card."""
    software = dict(manifest.software)
    version, renderer = software.pop("adc_bench"), software.pop("renderer")
    drives = manifest.kind == "drives"
    return TEMPLATE.format(
        split=manifest.split.name,
        kind=manifest.kind,
        what=f"{manifest.count} drives" if drives else f"{summary.frames} pictures in {summary.scenarios} arenas",
        version=version,
        picture=CARD_PICTURE,
        totals=_rows(_totals(manifest, summary)),
        cameras=_rows(summary.cameras),
        light_levels=_rows(summary.light_levels),
        tunnel_frames=summary.tunnel_frames,
        boxes=_rows(summary.boxes),
        ignored=summary.ignored,
        shards=DRIVE_SHARDS if drives else FRAME_SHARDS,
        coco=_coco_line(manifest),
        poses=DRIVE_POSES if drives else FRAME_POSES,
        command=_command(manifest),
        sha256=manifest.split_sha256,
        salt=f", made with the salt whose sha256 is `{manifest.salt_sha256}`" if manifest.salt_sha256 else "",
        renderer=renderer,
        packages=", ".join(f"{name} {number}" for name, number in sorted(software.items())),
    )


FRAME_SHARDS = "up to some hundred pictures each, with labels, lane lines, conditions and poses, and their arenas."
DRIVE_SHARDS = "one drive each: truth, commands, encoders, gyro, laser, contacts, and every picture with its labels."
FRAME_POSES = "`poses/<camera>.tum`: true camera poses, frame index in place of time."
DRIVE_POSES = "`poses/drive-*.tum`: the robot's true poses, simulated seconds."


def _totals(manifest: Manifest, summary: Summary) -> dict[str, str]:
    mount = manifest.cameras[0]
    totals = {
        "pictures": f"{summary.frames} of {mount.width_px}x{mount.height_px} pixels",
        "arenas": f"{summary.scenarios}",
        "boxes": f"{sum(summary.boxes.values())}",
        "shards": f"{len(manifest.shards)}, {summary.size_bytes / 1e6:.1f} MB",
        "quality": manifest.quality,
    }
    if manifest.extras:
        totals["with"] = ", ".join(manifest.extras)
    if summary.driving:
        driven = summary.driving
        totals["driven"] = f"{driven.drives} drives, {driven.simulated_s:.0f} s, {driven.distance_m:.0f} m"
    return totals


def _coco_line(manifest: Manifest) -> str:
    if manifest.has_coco:
        return f"`{COCO}`: COCO; `file_name` is `shard-00000.h5#row`, an image's id its frame index."
    return f"no `{COCO}` beside the shards: `adc-bench dataset export --format coco` writes one."


def _command(manifest: Manifest) -> str:
    mount = manifest.cameras[0]
    words = ["adc-bench", "render", "--split", manifest.split.name, "--kind", manifest.kind]
    words += ["--frames", str(manifest.count), "--size", f"{mount.width_px}x{mount.height_px}"]
    if manifest.kind == "frames":
        words += ["--frames-per-shard", str(manifest.frames_per_shard)]
    words += ["--quality", manifest.quality, *(f"--{extra}" for extra in manifest.extras)]
    if manifest.salt_sha256:
        words += ["--salt-file", "FILE"]
    return " ".join([*words, "--out", "DIR"])


def _rows(counts: dict[str, int] | dict[str, str]) -> str:
    return "\n".join(f"| {name} | {count} |" for name, count in counts.items())
