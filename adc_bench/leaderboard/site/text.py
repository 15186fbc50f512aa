"""Words of the pages, and the frame of every page."""

from functools import cache
from html import escape
from importlib.resources import files
from string import Template

DASH = "–"


def asset(name: str) -> str:
    """Return the text of a file that lies beside this module."""
    return files("adc_bench.leaderboard.site").joinpath(name).read_text(encoding="utf-8")


@cache
def _frame() -> Template:
    return Template(asset("page.html"))


def page(title: str, body: str, *, root: str, script: str) -> bytes:
    """Return a page; `root` leads from it to the site's folder, `script` is the file of its script there."""
    return _frame().substitute(title=escape(title), body=body, root=root, script=script).encode()


def plural(count: int, what: str) -> str:
    """Return a count of things in words."""
    return f"{count} {what}{'' if count == 1 else 's'}"
