"""The leaderboard as a static site: pages that need no server, no script from elsewhere, no font but the reader's."""

from adc_bench.leaderboard.site.write import write_site

__all__ = ["write_site"]
