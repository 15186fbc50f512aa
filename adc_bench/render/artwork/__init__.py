"""What is printed or shown: the panels' pictures, the vertical signs' boards, posters."""

from adc_bench.render.artwork.panels import panel_picture
from adc_bench.render.artwork.posters import poster_picture
from adc_bench.render.artwork.signs import sign_picture

__all__ = ["panel_picture", "poster_picture", "sign_picture"]
