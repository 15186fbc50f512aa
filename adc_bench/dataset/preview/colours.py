"""The colours of labels, by their kind."""

from collections.abc import Mapping

Colour = tuple[int, int, int]

COLOURS: Mapping[str, Colour] = {
    "crosswalk": (255, 200, 0),
    "panel": (0, 230, 120),
    "sign": (80, 170, 255),
    "box": (255, 90, 90),
    "cone": (255, 120, 255),
}
IGNORED_COLOUR: Colour = (150, 150, 150)


def colour_of(category: str, *, ignored: bool) -> Colour:
    """Return the rgb colour of a category's labels; ignore regions are grey."""
    return IGNORED_COLOUR if ignored else COLOURS[category.split("_")[0]]
