"""What is wrong with a dataset: one sentence each, with its place."""

from typing import NamedTuple


class Fault(NamedTuple):
    """Something wrong in a shard: in a row of it, or in the file as a whole (row None)."""

    row: int | None
    text: str
