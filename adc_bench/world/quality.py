"""What pictures are asked for: one of three qualities (scored drives always use `fast`), and what comes with them."""

from typing import Literal, get_args

Quality = Literal["fast", "standard", "raytraced"]
Extra = Literal["depth", "semantic"]  # what a frame has only where it is asked for
QUALITIES: tuple[Quality, ...] = get_args(Quality)
