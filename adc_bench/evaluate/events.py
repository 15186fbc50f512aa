"""What happened in a run, and when: read off its log and its score."""

from itertools import accumulate, pairwise
from typing import Literal

import msgspec

from adc_bench.evaluate.log import EpisodeLog
from adc_bench.evaluate.score import Episode

Kind = Literal["panel", "lap", "fault", "end"]


class Event(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Something that happened at a time, in words."""

    time_s: float
    kind: Kind
    text: str


def events_of(log: EpisodeLog, episode: Episode) -> tuple[Event, ...]:
    """Return a run's events in order of time."""
    found = [*_panels(log), *_laps(episode), *_faults(episode)]
    ended = f"{_words(episode.reason)} ({episode.status})"
    return (*sorted(found, key=lambda event: event.time_s), _event(episode.sim_time_s, "end", ended))


def _event(time_s: float, kind: Kind, text: str) -> Event:
    return Event(time_s=round(time_s, 3), kind=kind, text=text)


def _panels(log: EpisodeLog) -> list[Event]:
    shown = [log.rows[0], *(after for before, after in pairwise(log.rows) if after.panel != before.panel)]
    return [_event(row.time_s, "panel", f"panels: {row.panel}") for row in shown]


def _laps(episode: Episode) -> list[Event]:
    _, *ends_s = accumulate(episode.laps_s, initial=episode.arrow_s)
    laps = enumerate(zip(ends_s, episode.laps_s, strict=True), start=1)
    return [_event(end_s, "lap", f"lap {number} in {lap_s:.2f} s") for number, (end_s, lap_s) in laps]


def _faults(episode: Episode) -> list[Event]:
    told = [(fault, f": {_words(fault.what)}" if fault.what else "") for fault in episode.faults]
    return [_event(fault.time_s, "fault", f"{_words(fault.kind)}{what}") for fault, what in told]


def _words(name: str) -> str:
    return name.replace("-", " ").replace("_", " ")
