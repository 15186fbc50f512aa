"""Figures as PNG, on light or on dark paper."""

import io
from collections.abc import Callable

import matplotlib as mpl
from cycler import cycler
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

Draw = Callable[[Figure], None]
INKS = {"light": "#1c2127", "dark": "#e4e7eb"}
COLOURS = ("#3b7fb6", "#d9822b", "#3f9d5a", "#b04a5a", "#8467b8", "#8f7a2f")


def png(draw: Draw, ink: str, size_in: tuple[float, float] = (6.4, 4.2), paper: str = "none") -> bytes:
    """Return what `draw` draws, with writing in the colour `ink` on paper of a colour, or on none."""
    with mpl.rc_context(
        {
            "text.color": ink,
            "axes.edgecolor": ink,
            "axes.labelcolor": ink,
            "xtick.color": ink,
            "ytick.color": ink,
            "axes.prop_cycle": cycler(color=COLOURS),
        }
    ):
        figure = Figure(figsize=size_in, layout="constrained", facecolor=paper)
        FigureCanvasAgg(figure)
        draw(figure)
        for axes in figure.axes:
            axes.set_facecolor("none")
            axes.grid(alpha=0.25)
            if axes.get_legend_handles_labels()[0]:
                axes.legend(fontsize="small", framealpha=0.0, markerscale=2)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    return buffer.getvalue()
