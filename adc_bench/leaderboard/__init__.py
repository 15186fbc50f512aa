"""The leaderboard: one validated JSON file an entry, ranked, exported, and shown as a table and as a site."""

from adc_bench.leaderboard.board import add, check, entries_in
from adc_bench.leaderboard.ranking import ranking
from adc_bench.leaderboard.site import write_site

__all__ = ["add", "check", "entries_in", "ranking", "write_site"]
