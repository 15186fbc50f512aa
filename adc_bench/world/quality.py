"""The three qualities of a picture; scored drives always use `fast`."""

from typing import Literal, get_args

Quality = Literal["fast", "standard", "raytraced"]
QUALITIES: tuple[Quality, ...] = get_args(Quality)
