"""What `make demo` has made: files, detector, drive, time. Reads the files alone."""

import json
import sys
from pathlib import Path
from typing import Any


def main() -> None:
    demo, seconds = Path(sys.argv[1]), int(sys.argv[2])
    result = _read(demo / "drive" / "result.json")
    episode = result["episodes"][0]
    _section("made", [*(_dataset(demo / name) for name in ("train", "val")), *_files(demo)])
    _section("trained", _detector(_read(demo / "detector" / "metrics.json")["overall"]))
    _section("driven", [f"{key}: {text}" for key, text in _drive(result, episode).items()])
    _section("time", [f"{seconds // 60} min {seconds % 60} s"])
    if episode["completion"] < 1.0:
        sys.exit(f"error: the drive ended after {episode['completion']:.0%} of its laps: {episode['reason']}")


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _dataset(folder: Path) -> str:
    coco = _read(folder / "annotations" / "instances.json")
    return f"{folder}/: {len(coco['images'])} pictures, {len(coco['annotations'])} boxes"


def _files(demo: Path) -> list[str]:
    names = (
        "detector/weights.safetensors",
        "detector/predictions.png",
        "drive/result.json",
        "drive/paths.png",
        "leaderboard.json",
    )
    return [f"{demo / name}: {(demo / name).stat().st_size / 1e3:.0f} kB" for name in names]


def _detector(score: dict[str, Any]) -> list[str]:
    rows = (f"{name}: AP50 {row['ap50']:.3f} of {row['objects']}" for name, row in score["categories"].items())
    return [f"mAP50 {score['map50']:.3f} on {score['pictures']} validation pictures", *rows]


def _drive(result: dict[str, Any], episode: dict[str, Any]) -> dict[str, str]:
    place = episode["localization"]
    return {
        "submission": f"{result['submission']['name']} on {result['suite']}: {episode['status']}",
        "score": f"{episode['driving_score']:.1f} of 100",
        "laps": ", ".join(f"{lap_s:.1f} s" for lap_s in episode["laps_s"]) or "none",
        "position RMSE": f"{place['position_rmse_m']:.3f} m (dead reckoning: {place['dead_reckoning_rmse_m']:.3f} m)"
        if place
        else "no estimate",
        "line touches": str(episode["driving"]["line_touches"]),
        "collisions": str(len(episode["collisions"])),
    }


def _section(title: str, lines: list[str]) -> None:
    print(title)
    for line in lines:
        print(f"  {line}")


if __name__ == "__main__":
    main()
