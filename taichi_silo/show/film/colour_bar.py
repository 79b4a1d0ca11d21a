"""The colour bar of a field beside the sand."""

from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, NullLocator

from taichi_silo.runs.point_fields import Scale


def draw_scale(axes, scale: Scale, look: dict, missing) -> None:
    """Draw a scale into axes as high as the bar.

    Parameters
    ----------
    axes : of matplotlib.
    scale : of the field.
    look : of the ticks.
    missing : colour of what has no value.

    """
    ink = look["labelcolor"]
    if isinstance(scale.colours, tuple):
        _swatches(axes, scale, ink)
        return
    norm = (LogNorm if scale.decades else Normalize)(scale.low, scale.high)
    bar = axes.figure.colorbar(ScalarMappable(norm, scale.colours), cax=axes)
    label = bar.ax.yaxis.label
    bar.set_label(scale.label, fontsize=30, color=ink, labelpad=12)
    room = axes.get_window_extent().height * (0.96 if scale.missing else 1.1)
    label.set_fontsize(30 * min(1.0, room / label.get_window_extent().height))
    bar.locator = LogLocator(subs=(1.0, 2.0, 5.0)) if scale.decades else MaxNLocator(6, steps=[1, 2, 5, 10])
    bar.ax.yaxis.set_minor_locator(NullLocator())
    bar.ax.yaxis.set_minor_formatter(NullFormatter())
    if scale.decades:
        bar.formatter = lambda value, place: f"{value:g}"
    bar.outline.set_visible(False)
    bar.ax.tick_params(**look)
    words = zip((-0.02, 1.02), ("top", "bottom"), scale.words, strict=True)
    for height, align, word in words:
        axes.text(0.5, height, word, transform=axes.transAxes, fontsize=26, color=ink, ha="center", va=align)
    if scale.missing:
        tall = _tall(axes)
        _swatch(axes, -max(min(0.13, 2.0 * tall), 1.3 * tall), missing, scale.missing, ink)


def _swatches(axes, scale: Scale, ink) -> None:
    """A square for each class."""
    axes.set_axis_off()
    step = max(0.12, 1.2 * _tall(axes))
    for number, (colour, word) in enumerate(zip(scale.colours, scale.words, strict=True)):
        _swatch(axes, 0.5 + step * (0.5 * len(scale.colours) - 1 - number), colour, word, ink)


def _swatch(axes, height: float, colour, word: str, ink) -> None:
    """A square of a colour with its meaning, at a height of the axes between 0 and 1."""
    tall = _tall(axes)
    axes.add_patch(Rectangle((0.0, height), 1.0, tall, transform=axes.transAxes, color=colour, clip_on=False, lw=0))
    axes.text(1.4, height + 0.5 * tall, word, transform=axes.transAxes, fontsize=26, color=ink, va="center")


def _tall(axes) -> float:
    """Height of a square as wide as the bar, as a share of the bar's."""
    box = axes.get_window_extent()
    return box.width / box.height
