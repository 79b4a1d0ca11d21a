"""One picture as SVG: lines and letters stay sharp at any size, the sand is an image in it."""

import io
import re
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from taichi_silo.show.film.canvas import Canvas
from taichi_silo.show.film.curves import FORCES, HALF_WIDTH, LIGHT, LOWEST, Curves, apart
from taichi_silo.show.film.lettering import INK
from taichi_silo.show.film.moments import Moment
from taichi_silo.show.film.renderer import Renderer


def write_svg(renderer: Renderer, moment: Moment, file: Path) -> None:
    """Write the picture of a moment."""
    renderer.tell(moment)
    picture = renderer.picture
    sand, canvas = picture.sand(*renderer.between.at(moment.time_s), moment), picture.canvas
    figure, silo, forces = canvas.furniture
    silo.imshow(sand, extent=(*silo.get_xlim(), *silo.get_ylim()), aspect="auto", interpolation="none", zorder=1)
    if renderer.picture.look.transparent:
        figure.set_facecolor("none")
        silo.set_facecolor("none")
        if forces:
            forces.set_facecolor("none")
    _walls(canvas)
    if forces is not None and canvas.curves is not None:
        _words(canvas, moment)
        _curves(forces, canvas.curves, canvas.course.scale)
    with matplotlib.rc_context({"svg.hashsalt": "taichi_silo"}):  # the same picture is the same file
        text = io.StringIO()
        figure.savefig(text, format="svg", facecolor=figure.get_facecolor(), metadata={"Date": None})
    columns, rows = canvas.layout.size
    sized = re.sub(
        r'(<svg [^>]*?)width="[^"]*" height="[^"]*"', rf'\1width="{columns}" height="{rows}"', text.getvalue(), count=1
    )
    file.write_text(sized, encoding="utf-8")


def _walls(canvas: Canvas) -> None:
    figure = canvas.furniture.figure
    for box in canvas.wall_boxes():
        left, low, wide, high = box.fractions(canvas.layout.size)
        figure.add_artist(Rectangle((left, low), wide, high, transform=figure.transFigure, color=_shade(INK), lw=0))


def _words(canvas: Canvas, moment: Moment) -> None:
    """Write title and readings where the frames of a film have them."""
    figure, zoom = canvas.furniture.figure, canvas.layout.zoom

    def write(x: float, y: float, text: str, size: float, colour=INK, **look) -> None:
        """Write a text at pixels of the page."""
        place = x / canvas.layout.size[0], 1.0 - y / canvas.layout.size[1]
        figure.text(*place, text, fontsize=size, color=_shade(colour), parse_math=False, **look)

    for middle, line, size in canvas.title_lines():
        write(60 * zoom, middle * zoom, line, size, fontweight="bold", va="center_baseline")
    for x, y, text, colour, size in canvas.captions():
        write(x, y, text, size, colour, va="baseline")
    texts = canvas.texts(moment.time_s, moment.stage, moment.progress)
    for (x, y), text in zip(canvas.layout.readings, texts, strict=True):
        write(x, y, text, canvas.letters, fontweight="bold", va="baseline")


def _curves(forces: Axes, curves: Curves, scale: float) -> None:
    places = [scale * place for place, _, _ in curves.rows]
    spread = [band for _, _, band in curves.rows if band is not None]
    for k, (_, _, colour) in enumerate(FORCES):
        if spread:
            low, high = ([1e-3 * band[k, end] for band in spread] for end in (0, 1))
            forces.fill_between(places, low, high, color=_shade(colour), alpha=LIGHT, linewidth=0)
        values = [1e-3 * row[k] for _, row, _ in curves.rows]
        forces.plot(places, values, color=_shade(colour), linewidth=2 * HALF_WIDTH, solid_capstyle="round")
    if curves.tip is None:
        return
    plot, zoom, order = curves.plot, curves.layout.zoom, curves.tip[:, 1].argsort()
    across = forces.get_xlim()[1] * curves.tip[0, 0] / (plot.columns - 1)
    heights = apart(curves.tip[order, 1].clip(0, plot.rows - 1), 36 * zoom, plot.rows - LOWEST * zoom)
    for height, k in zip(heights, order, strict=True):
        letter, _, colour = FORCES[k]
        own = 1e-3 * curves.top_force * (1.0 - curves.tip[k, 1] / (plot.rows - 1))
        forces.plot(
            across, own, "o", color=_shade(colour), markersize=19, markeredgecolor="white", markeredgewidth=3,
            clip_on=False, zorder=4,
        )  # fmt: skip
        forces.annotate(
            letter, (across, 1e-3 * curves.top_force * (1.0 - height / (plot.rows - 1))), (20, 0),
            textcoords="offset points", fontsize=36, fontweight="bold", color=_shade(colour), va="center",
            annotation_clip=False,
        )  # fmt: skip


def _shade(colour: tuple) -> tuple[float, ...]:
    return tuple(channel / 255 for channel in colour)
