"""The dataset's card: its README.md."""

from adc_bench.dataset.layout import COCO, Manifest, Summary

TEMPLATE = """\
# adc-bench dataset: split `{split}`

{frames} pictures of {width_px}x{height_px} pixels from {scenarios} arenas of the ADC figure-eight course, taken through
the robot's cameras, rendered and labelled by adc-bench {version}. Every picture, label and pose is synthetic.

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
- `dataset.toml`: what made it: the split and its digest, cameras, package versions, the digest of each shard.
- `shard-*.h5`: pictures (`jpeg` with `jpeg_offset`), `frame_index`, `camera_index`, `pose_world_camera` (4x4),
  `pose_world_robot` (x, y, yaw), `record` (labels and conditions as JSON) and `scenario` (the arenas as JSON).
- {coco}
- `poses/<camera>.tum`: true camera poses, frame index in place of time.

Metres and radians. World: origin midway between the loops, x along the long axis, z up. Camera: x right, y down,
z forward. Boxes are tight around visible pixels; pixel centres lie at whole numbers plus one half.

## Make it again
`adc-bench render --split {split} --frames {frames} --size {width_px}x{height_px} --out DIR` with the same versions.
Split digest (sha256): `{sha256}`
"""

COCO_LINE = f"`{COCO}`: COCO; `file_name` is `shard-00000.h5#row`, an image's id its frame index."
NO_COCO_LINE = f"no `{COCO}`: too large to be loaded; `adc-bench dataset export --format coco` writes one"


def card(manifest: Manifest, summary: Summary) -> str:
    """Return the text of the card."""
    return TEMPLATE.format(
        split=manifest.split.name,
        sha256=manifest.split_sha256,
        version=manifest.software["adc_bench"],
        width_px=manifest.cameras[0].width_px,
        height_px=manifest.cameras[0].height_px,
        frames=summary.frames,
        scenarios=summary.scenarios,
        tunnel_frames=summary.tunnel_frames,
        ignored=summary.ignored,
        cameras=_rows(summary.cameras),
        light_levels=_rows(summary.light_levels),
        boxes=_rows(summary.boxes),
        coco=COCO_LINE if manifest.has_coco else NO_COCO_LINE,
    )


def _rows(counts: dict[str, int]) -> str:
    return "\n".join(f"| {name} | {count} |" for name, count in counts.items())
