"""All experiments into one folder: what is there is kept, what is missing is driven; then tables, figures and page."""

from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TypeVar

import msgspec

from adc_bench import __version__
from adc_bench.dataset.layout import write_file
from adc_bench.detector import Detector, shipped_weights
from adc_bench.detector.decode import DecodeConfig
from adc_bench.errors import InputError
from adc_bench.evaluate.driving import PACKAGES
from adc_bench.evaluate.episode import process_renderer
from adc_bench.evaluate.results import to_json
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.submission import load_submission
from adc_bench.reproduce.approach import LEAST_SCORE, Approach, approach_arena, approach_places_m, best_scores
from adc_bench.reproduce.avoidance import Avoidance, go_round
from adc_bench.reproduce.figures import drawings, png_on_white
from adc_bench.reproduce.filters import Estimate, dead_reckoned, filtered
from adc_bench.reproduce.laps import Lap, drive_lap
from adc_bench.reproduce.page import page_of
from adc_bench.reproduce.pixels import drive_from_pixels
from adc_bench.reproduce.results import Results, lap_name
from adc_bench.reproduce.settings import Settings
from adc_bench.reproduce.tables import Tables, tables_of

Record = TypeVar("Record", bound=msgspec.Struct)
Tell = Callable[[int, int, str], None]
ROAD = "road"


class Made(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a folder's experiments were driven with; `run.json`. `sha256` covers this package and its weights."""

    schema: str = "adc-bench-thesis-1"
    settings: Settings
    software: dict[str, str]
    sha256: str


def reproduce(out: Path, settings: Settings | None = None, tell: Tell = lambda done, total, what: None) -> Tables:
    """Drive what is missing in the folder `out`, and write `tables.json`, `figures/*.png` and `index.html` there.

    `tell` hears how many experiments are done, of how many, and which one comes next. Equal inputs give equal bytes.

    Raises:
        InputError: the folder holds experiments of other settings or another version, or a damaged file.
        MachineError: this machine cannot render.
    """
    settings = settings or Settings()
    _claim(out, Made(settings=settings, software=_software(), sha256=load_submission("thesis", {}).id.sha256))
    results = _results(out / "experiments", settings, tell)
    tables = tables_of(results)
    write_file(out / "tables.json", to_json(tables))
    figures = drawings(results)
    pngs = {name: png_on_white(drawn) for name, drawn in figures.items()}
    for name, png in pngs.items():
        write_file(out / "figures" / f"{name}.png", png)
    write_file(out / "index.html", page_of(tables, figures, pngs))
    return tables


def _software() -> dict[str, str]:
    return {"adc_bench": __version__, **{name: version(name) for name in PACKAGES}}


def _claim(out: Path, made: Made) -> None:
    path, wanted = out / "run.json", to_json(made)
    if not path.is_file():
        write_file(path, wanted)
    elif path.read_bytes() != wanted:
        raise InputError(
            where=str(path),
            found="experiments with other settings or by another version",
            wanted="a new folder, or one made by this command with this version",
            todo="name another --out, or delete the folder",
        )


class _Folder:
    """The experiments' files; the ones that are missing are made."""

    def __init__(self, root: Path, total: int, tell: Tell) -> None:
        self._root, self.total, self._tell, self._done = root, total, tell, 0

    def kept(self, name: str, kind: type[Record], make: Callable[[], Record]) -> Record:
        self._tell(self._done, self.total, name)
        path = self._root / f"{name}.json"
        record = _read(path, kind) if path.is_file() else make()
        if not path.is_file():
            write_file(path, to_json(record))
        self._done += 1
        return record


def _results(root: Path, settings: Settings, tell: Tell) -> Results:
    """Return all experiments' results, from their files or driven now."""
    folder = _Folder(root, len(settings.laps) + len(settings.boxes_s_m) + settings.robots + 3, tell)
    laps = {
        lap_name(*each): folder.kept(f"lap-{lap_name(*each)}", Lap, partial(drive_lap, *each, settings.seed))
        for each in settings.laps
    }
    first = laps[lap_name(*settings.laps[0])]
    results = Results(
        settings=settings,
        laps=laps,
        reckoned=tuple(
            folder.kept(f"odometry-{k}", Estimate, partial(_reckoned, settings, k, first))
            for k in range(settings.robots)
        ),
        filtered=folder.kept("filter", Estimate, lambda: filtered(first, settings.seed, settings.landmarks)),
        pixels=folder.kept("pixels", Estimate, lambda: drive_from_pixels(settings)),
        approach=folder.kept("approach", Approach, lambda: _approach(settings)),
        avoidances=tuple(
            folder.kept(f"boxes-{k}", Avoidance, partial(go_round, each, settings.boxes_speed_mps, settings.seed))
            for k, each in enumerate(settings.boxes_s_m)
        ),
    )
    tell(folder.total, folder.total, "tables and figures")
    return results


def _reckoned(settings: Settings, robot: int, first: Lap) -> Estimate:
    """Return the first lap's dead reckoning by another robot; robot 0 drove it already."""
    return dead_reckoned(drive_lap(*settings.laps[0], settings.seed + robot) if robot else first)


def _approach(settings: Settings) -> Approach:
    renderer, places_m = process_renderer(RULES.rig), approach_places_m(settings.approach_step_m)
    detector = Detector.load(shipped_weights(), config=DecodeConfig(score_min=LEAST_SCORE))
    scores: dict[str, tuple[float, ...]] = {}
    for number, level in enumerate(settings.approach_lights):
        scenario = approach_arena(number, level, "open", RULES.rig)
        renderer.load(scenario)
        scores[level] = tuple(best_scores(renderer, detector, ROAD, scenario, places_m))
    return Approach(camera=ROAD, places_m=places_m, scores=scores)


def _read(path: Path, kind: type[Record]) -> Record:
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except msgspec.DecodeError as error:
        raise InputError(
            where=str(path),
            found=f"a damaged file: {error}",
            wanted="an experiment's result",
            todo="delete it and run the command again: it drives what is missing",
        ) from None
