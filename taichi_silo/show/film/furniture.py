"""All of a page that never changes, as a figure of matplotlib: axes, colour bar, the line of the weight."""

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from taichi_silo.runs.point_fields import Scale
from taichi_silo.show.film.colour_bar import draw_scale
from taichi_silo.show.film.curves import Course
from taichi_silo.show.film.layout import WALL, Layout, View
from taichi_silo.show.film.lettering import INK, fitting
from taichi_silo.show.report.words import length_unit, number

MISSING = (190, 190, 190)  # sand without a value
LINE = 34  # height of the label of a tick, with air


class Furniture(NamedTuple):
    """The figure, with the axes of the sand and of the forces, where there are any."""

    figure: Figure
    silo: Axes
    forces: Axes | None


def furniture(layout: Layout, view: View, weight: float, scale: Scale, course: Course, top_force: float, note: str):
    """Draw it.

    Parameters
    ----------
    layout : of the page.
    view : what is seen of the silo [m].
    weight, top_force : of the sand, and upper end of the axis of forces [N/m].
    scale : of the colours.
    course : of the curves.
    note : what the curves are, if there is something to say.

    """
    dots = 72 * layout.zoom  # to the inch: one point of matplotlib is one pixel of the layout
    figure = Figure(figsize=(layout.size[0] / dots, layout.size[1] / dots), dpi=dots, facecolor="white")
    ink = tuple(channel / 255 for channel in INK)
    look: dict[str, Any] = {"labelsize": 26, "length": 8, "width": 2, "color": ink, "labelcolor": ink}
    silo = figure.add_axes(layout.panel.fractions(layout.size))
    _sand(silo, layout, view, look)
    if layout.bar is None or layout.plot is None:
        return Furniture(figure, silo, None)
    draw_scale(figure.add_axes(layout.bar.fractions(layout.size)), scale, look, np.array(MISSING) / 255)
    forces = figure.add_axes(layout.plot.fractions(layout.size))
    _forces(forces, layout, weight, course, top_force, note, look)
    return Furniture(figure, silo, forces)


def _sand(silo: Axes, layout: Layout, view: View, look: dict) -> None:
    """Draw the axes of the sand."""
    panel, zoom, ink = layout.panel, layout.zoom, look["color"]
    bottom_m = view.top - panel.rows / layout.pixels_per_metre
    unit, per_m = length_unit(max(view.top - view.bottom, view.right - view.left))
    across, along = (per_m * view.left, per_m * view.right), (per_m * bottom_m, per_m * view.top)
    silo.set(xlim=across, ylim=along, facecolor="#f3f3f3")
    silo.spines[:].set_visible(False)
    if not layout.axes:
        silo.set(xticks=[], yticks=[])
        return
    wide, high = panel.columns / zoom, panel.rows / zoom
    silo.set_xlabel(f"x ({unit})", fontsize=28, color=ink)
    silo.set_ylabel(f"y ({unit})" if high > 110 else "", fontsize=28, color=ink)
    ticks = min(4, 1 + round(wide) // 100) if wide < 700 else 8
    silo.xaxis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))
    silo.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    if high < 250:  # as many as have room
        low, top = silo.get_ylim()
        places = [place for place in silo.get_yticks() if low <= place <= top]
        every = math.ceil(LINE * (top - low) / (high * max(places[1] - places[0], 1e-9))) if len(places) > 1 else 1
        silo.set_yticks(places[::every])
    for side in ("left", "bottom"):
        silo.spines[side].set_position(("outward", WALL))
    silo.tick_params(**look)
    if wide < 60:  # the labels of two ticks are wider than the silo
        for label, side in zip(_labelled(silo, across), ("right", "left"), strict=True):
            label.set_horizontalalignment(side)


def _labelled(silo: Axes, ends: tuple[float, float]) -> list:
    """The labels of ticks at both ends of the x axis."""
    silo.set_xticks(ends, [f"{end:.4g}" for end in ends])
    return silo.get_xticklabels()


def _forces(forces: Axes, layout: Layout, weight, course: Course, top_force: float, note: str, look: dict) -> None:
    """Draw the axes of the forces."""
    plot, zoom, ink = layout.plot, layout.zoom, look["color"]
    assert plot is not None
    wide, high = plot.columns / zoom, plot.rows / zoom
    forces.set(xlim=(0, course.scale * course.end), ylim=(0, 1e-3 * top_force))
    forces.set_xlabel(course.label, fontsize=fitting(course.label, 28, zoom, plot.columns + 100 * zoom), color=ink)
    name = f"force per {course.per} (kN/m)"
    forces.set_ylabel(name, fontsize=fitting(name, 30, zoom, plot.rows), color=ink, labelpad=12)
    forces.xaxis.set_major_locator(MaxNLocator(6 if wide > 450 else max(2, int(wide / 90)), steps=[1, 2, 2.5, 5, 10]))
    if high < 400:
        forces.yaxis.set_major_locator(MaxNLocator(max(2, int(high / 60)), steps=[1, 2, 2.5, 5, 10]))
    forces.grid(color="#e4e4e4", linewidth=2)
    forces.set_axisbelow(True)
    forces.spines[["top", "right"]].set_visible(False)
    forces.spines[["left", "bottom"]].set(linewidth=2, color=ink)
    forces.axhline(1e-3 * weight, color="#777777", linewidth=2.5, linestyle=(0, (6, 4)))
    words = f"weight of the sand {number(1e-3 * weight, 4)} kN/m"
    size = fitting(words, 26, zoom, 0.97 * plot.columns)
    label = forces.text(
        0.985,
        weight / top_force - 0.015,
        words,
        transform=forces.transAxes,
        fontsize=size,
        color="#555555",
        ha="right",
        va="top",
    )
    wide_px = label.get_window_extent().width  # letters of a few pixels are wider than their size says
    label.set_fontsize(size * min(1.0, 0.97 * plot.columns / wide_px))
    if note:
        size = min(fitting(note, 26, zoom, 0.97 * plot.columns), 0.07 * high)
        forces.text(0.985, 1.0, note, transform=forces.transAxes, fontsize=size, color="#555555", ha="right", va="top")
    forces.tick_params(**look)
