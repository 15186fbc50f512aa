"""Visuals: a scenario as a lit SAPIEN scene, delivered pictures, labels from them."""

from adc_bench.render.renderer import ArenaRenderer

__all__ = ["ArenaRenderer"]
