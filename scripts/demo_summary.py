"""What `make demo` has made: files, detector, drive, time. Reads the files alone."""

import json
import sys
from pathlib import Path
from typing import Any


def main() -> None:
    demo, seconds = Path(sys.argv[1]), int(sys.argv[2])
    result = _read(demo / "drive" / "result.json")
    _section("made", [*(_dataset(demo / name) for name in ("train", "val")), *_files(demo)])
    _section("trained", _detector(_read(demo / "detector" / "metrics.json")["overall"]))
    _section("driven", [f"{key}: {text}" for key, text in _drive(result).items()])
    _section("time", [f"{seconds // 60} min {seconds % 60} s"])
    if not _finished(result):
        reasons = ", ".join(sorted({episode["reason"] for episode in result["episodes"]}))
        sys.exit(f"error: not one drive came to its end: {reasons}")


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
        "site/index.html",
    )
    return [f"{demo / name}: {(demo / name).stat().st_size / 1e3:.0f} kB" for name in names]


def _detector(score: dict[str, Any]) -> list[str]:
    rows = (f"{name}: AP50 {row['ap50']:.3f} of {row['objects']}" for name, row in score["categories"].items())
    return [f"mAP50 {score['map50']:.3f} on {score['pictures']} validation pictures", *rows]


def _finished(result: dict[str, Any]) -> int:
    return sum(episode["completion"] == 1.0 for episode in result["episodes"])


def _drive(result: dict[str, Any]) -> dict[str, str]:
    means = {name: figure["mean"] for name, figure in result["summary"].items()}
    place, reckoned = means.get("position_rmse_m"), means.get("dead_reckoning_rmse_m")
    return {
        "submission": f"{result['submission']['name']} on {result['suite']}",
        "drives of two laps that came to their end": f"{_finished(result)} of {len(result['episodes'])}",
        "score": f"{means['driving_score']:.1f} of 100",
        "lap time": f"{means['lap_time_s']:.1f} s" if "lap_time_s" in means else "none",
        "position RMSE": f"{place:.3f} m (dead reckoning: {reckoned:.3f} m)" if place and reckoned else "no estimate",
        "line touches a drive": f"{means['line_touches']:.1f}",
        "collisions a drive": f"{means['collisions']:.1f}",
    }


def _section(title: str, lines: list[str]) -> None:
    print(title)
    for line in lines:
        print(f"  {line}")


if __name__ == "__main__":
    main()
