"""The look shared by all figures: colours that colour-blind readers tell apart, sizes, a light grid."""

import logging
import textwrap
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)  # a font of formulas that is missing costs nothing

BLACK, BLUE, VERMILLION, GREEN = "#000000", "#0072B2", "#D55E00", "#009E73"  # palette of Okabe and Ito
PURPLE, ORANGE, SKY = "#CC79A7", "#E69F00", "#56B4E9"
COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)  # one after the other, where they mean nothing
WORDS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY)  # of values that are words, and of components
REFERENCE = "#555555"  # theory and reference lines
LEAST_LOG, MOST_FOR_125 = 5.0, 1000.0  # ratio of the ends from which 1, 2, 5 are ticks enough, and up to which they fit

STYLE: Any = {
    "font.size": 12,
    "axes.titlesize": 12.5,
    "axes.labelsize": 12,
    "legend.fontsize": 11,
    "figure.titlesize": 13,
    "savefig.dpi": 150,
    "figure.dpi": 150,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#404040",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.8,
    "lines.linewidth": 2.0,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.handlelength": 2.0,
    "mathtext.default": "regular",
}


def new_figure(width_in: float, height_in: float) -> Figure:
    """Return an empty figure that arranges its own margins and belongs to no global state."""
    return Figure(figsize=(width_in, height_in), layout=ConstrainedLayoutEngine(w_pad=0.06, h_pad=0.06))


def put_title(figure: Figure, *lines: str):
    """Put a title above a figure; a line that is too long for it goes on in the next one, which begins with no unit."""
    fitting = int(figure.get_figwidth() * 9.7)  # characters of its size
    whole = (line.replace(" mm", "\u00a0mm").replace(" = ", "\u00a0=\u00a0") for line in lines)
    figure.suptitle("\n".join(_balanced(line, fitting) for line in whole))


def _balanced(line: str, fitting: int) -> str:
    """A line in as few lines of so many characters as it needs, all about as long as each other."""
    needed = len(textwrap.wrap(line, fitting))
    width = next(width for width in range(max(1, len(line) // max(needed, 1)), fitting + 1)
                 if len(textwrap.wrap(line, width)) <= needed)  # fmt: skip
    return textwrap.fill(line, width)


def legend_below(figure: Figure, handles, labels, columns: int):
    """Put a legend below the figure, in so many columns or as many as it has room for; returns it."""
    handles, labels = list(handles), list(labels)
    renderer = FigureCanvasAgg(figure).get_renderer()
    for number in range(min(columns, len(labels)), 0, -1):
        legend = figure.legend(handles, labels, loc="outside lower center", ncols=number)
        if number == 1 or legend.get_window_extent(renderer).width < figure.bbox.width:
            return legend
        legend.remove()
    return None


def start_at_zero(panels, axis: str):
    """Let the x or y axis of finished panels start at zero, or below it where data go clearly below."""
    panels = list(panels)
    low = min(getattr(panel.dataLim, f"{axis}min") for panel in panels)
    high = max(getattr(panel.dataLim, f"{axis}max") for panel in panels)
    if not low <= high or high <= 0.0:  # nothing drawn, or nothing above zero
        return
    for panel in panels:
        getattr(panel, f"set_{axis}lim")(1.05 * low if low < -0.05 * high else 0.0, 1.07 * high)


def make_logarithmic(axis):
    """Make a finished panel's axis logarithmic, with plain numbers that do not touch."""
    if axis.get_scale() != "log":  # else those that share it would lose what follows
        getattr(axis.axes, f"set_{axis.axis_name}scale")("log")
    low, high = sorted(axis.get_view_interval())
    steps = (1.0, 2.0, 5.0) if high < MOST_FOR_125 * low else (1.0,)
    axis.set_major_locator(LogLocator(subs=steps, numticks=9) if high > LEAST_LOG * low else MaxNLocator(4))
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_locator(NullLocator())
