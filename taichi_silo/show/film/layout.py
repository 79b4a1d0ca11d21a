"""Where on a page the sand, the colour bar, the force curves and the readings stand, for any form of page and of silo.

Beside: the sand left, the curves right. Above: the sand over the curves. The one that shows the sand larger is taken;
on a wide page "beside" unless "above" gains a good deal. Lengths are those of a page of `PAGES`, times `zoom`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

SIZE = (1920, 1080)  # of a film, columns and rows
PAGES = {"16:9": SIZE, "9:16": (1080, 1920), "1:1": (1400, 1400)}  # as they are laid out
SIZES = {"16:9": SIZE, "9:16": (1080, 1920), "1:1": (1080, 1080)}  # as they are drawn, if no size is given
SAND = "sand"  # the layout without anything else
LAYOUTS = (*SIZES, SAND)
LONG_SIDE, SHORT_SIDE = 1920, 180  # of a page that the sand fills: its long side; its short side at least
WALL = 10  # thickness of a drawn wall
GAIN = 1.15  # times as large must the sand be above the curves of a wide page
BAR, BAR_LABELS = 36, 250  # width of the colour bar, and of what is written beside it
LEAST_BAR = 250  # its least height


class Box(NamedTuple):
    """A rectangle of the page in pixels, its row 0 at the top."""

    left: int
    top: int
    columns: int
    rows: int

    @property
    def slices(self) -> tuple[slice, slice]:
        """Index of the rectangle in an image array (rows, columns, 3)."""
        return slice(self.top, self.top + self.rows), slice(self.left, self.left + self.columns)

    def fractions(self, size: tuple[int, int]) -> tuple[float, float, float, float]:
        """Left, bottom, width and height in fractions of a page of this size, as matplotlib counts them."""
        bottom = size[1] - self.top - self.rows
        return self.left / size[0], bottom / size[1], self.columns / size[0], self.rows / size[1]


class View(NamedTuple):
    """The part of the plane of the silo that is seen [m]."""

    left: float
    bottom: float
    right: float
    top: float


class Layout(NamedTuple):
    """A page.

    Attributes
    ----------
    size : columns and rows.
    zoom : pixels to a length of the layout.
    panel : where the sand goes, exactly as wide as the view.
    pixels_per_metre : along both axes of the panel.
    bar, plot : of the colours and the force curves; none where the sand stands alone.
    readings : left end and base line of the six readings, and how wide each may be.
    axes : whether the sand has axes.

    """

    size: tuple[int, int]
    zoom: float
    panel: Box
    pixels_per_metre: float
    bar: Box | None = None
    plot: Box | None = None
    readings: tuple[tuple[int, int], ...] = ()
    axes: bool = True

    def long(self, length: float) -> int:
        """A length of the layout in pixels."""
        return max(1, round(self.zoom * length))


class _Page:
    """A page of one form while it is laid out for one view."""

    def __init__(self, size: tuple[int, int], view: View, axes: bool, at_most: float):
        form = math.log(size[0] / size[1])
        base = min(PAGES.values(), key=lambda page: abs(math.log(page[0] / page[1]) - form))
        self.size, self.axes, self.at_most = size, axes, at_most
        self.zoom = min(have / need for have, need in zip(size, base, strict=True))
        self.wide, self.high = (have / self.zoom for have in size)  # in lengths of the layout
        self.width_m, self.depth_m = view.right - view.left, view.top - view.bottom
        self.landscape = base == SIZE
        self.margin = 170 if axes else 60  # left of the sand
        self.under = 100 if axes else 40  # below it

    def px(self, length: float) -> int:
        return round(self.zoom * length)

    def long(self, length: float) -> int:
        return max(1, self.px(length))

    def panel(self, columns: float, rows: float) -> tuple[int, int, float]:
        """Columns, rows and scale of the sand in so much room."""
        wanted = self.width_m * min(rows / self.depth_m, columns / self.width_m)
        columns_px = max(1, int(min(self.long(wanted), self.at_most * self.width_m)))
        scale = columns_px / self.width_m
        return columns_px, max(1, round(self.depth_m * scale)), scale

    def made(self, panel: Box, scale: float, bar: Box, plot: Box, readings) -> Layout:
        return Layout(self.size, self.zoom, panel, scale, bar, plot, tuple(readings), self.axes)

    def grid(self, left: int, right: int, columns: int, lines: tuple[float, ...]) -> list[tuple[int, int]]:
        """Places of the readings, in so many columns between two pixels."""
        across = [left + round(k * (right - left) / columns) for k in range(columns)]
        return [(x, self.px(y)) for y in lines for x in across]

    def beside(self) -> Layout:
        """The sand left, the curves right; the readings above the curves, or on a narrow page above everything."""
        head, least = (110, 800) if self.landscape else (330, 360)
        room = self.high - head - self.under
        across = self.wide - self.margin - 385 - least - 85
        columns, rows, scale = self.panel(max(across, 10.0), room)
        middle = self.px(head + 0.5 * room)
        panel = Box(self.px(self.margin), middle - rows // 2, columns, rows)
        left, right = panel.left + columns + self.long(385), self.px(self.wide - 85)
        top = 310 if self.landscape else head + 15
        plot = Box(left, self.px(top), right - left, self.long(self.high - top - 100))
        tall = max(round(0.62 * rows), self.long(300))
        bar = Box(panel.left + columns + self.long(70), panel.top + (rows - tall) // 2, self.long(BAR), tall)
        if self.landscape:
            readings = self.grid(left, right, 3, (166, 266))
        else:
            readings = self.grid(self.px(60), self.px(self.wide - 40), 3, (180, 280))
        return self.made(panel, scale, bar, plot, readings)

    def above(self) -> Layout:
        """The sand over the curves; the bar beside the sand where there is room, else beside the curves."""
        lines, columns = ((190,), 6) if self.wide > 1800 else ((180, 280), 3)
        head = lines[-1] + 50
        least = max(260.0, 0.2 * self.high)  # height of the curves
        room = self.high - head - self.under - 40 - least - 105
        across = self.wide - self.margin - 60
        wide, rows, scale = self.panel(across, room)
        aside = rows >= self.long(LEAST_BAR) and wide <= self.zoom * (across - 70 - BAR - BAR_LABELS)
        group = wide + (self.long(70 + BAR + BAR_LABELS) if aside else 0)
        left = self.px(self.margin) + (self.px(across) - group) // 2
        panel = Box(left, self.px(head), wide, rows)
        top = panel.top + rows + self.px(self.under + 40)
        right = self.px(self.wide - 85) - (0 if aside else self.long(BAR + BAR_LABELS + 60))
        plot = Box(self.px(170), top, right - self.px(170), self.px(self.high - 105) - top)
        if aside:
            tall = max(round(0.62 * rows), self.long(LEAST_BAR))
            bar = Box(left + wide + self.long(70), panel.top + (rows - tall) // 2, self.long(BAR), tall)
        else:
            gap = self.long(34)
            bar = Box(right + self.long(110), top + gap, self.long(BAR), max(1, plot.rows - 2 * gap))
        return self.made(panel, scale, bar, plot, self.grid(self.px(60), self.px(self.wide - 40), columns, lines))


def layout(size: tuple[int, int], view: View, axes: bool = True, at_most: float = math.inf) -> Layout:
    """The page of a size for a view.

    Parameters
    ----------
    size : columns and rows.
    view : what is seen of the silo.
    axes : whether the sand has axes.
    at_most : pixels per metre.

    """
    page = _Page(size, view, axes, at_most)
    beside, above = page.beside(), page.above()
    gain = GAIN if page.landscape else 1.0
    return above if above.pixels_per_metre > gain * beside.pixels_per_metre else beside


def alone(size: tuple[int, int] | None, view: View, at_most: float = math.inf) -> Layout:
    """The page that the sand fills, wall to wall; without a size as large as the sand makes it."""
    wide, deep = view.right - view.left, view.top - view.bottom
    zoom = min(size) / SIZE[1] if size else 1.0
    wall = max(1, round(WALL * zoom))
    if size is None:
        scale = min((LONG_SIDE - 2 * wall) / wide, LONG_SIDE / deep, at_most)
        size = _even(scale * wide + 2 * wall), _even(scale * deep)
    scale = min((size[0] - 2 * wall) / wide, size[1] / deep, at_most)
    columns = max(1, int(scale * wide))
    scale = columns / wide
    rows = max(1, min(size[1], round(scale * deep)))
    panel = Box((size[0] - columns) // 2, (size[1] - rows) // 2, columns, rows)
    return Layout(size, zoom, panel, scale, axes=False)


def _even(length: float) -> int:
    """The next even number of pixels, not too small for a film."""
    return max(SHORT_SIDE, 2 * math.ceil(0.5 * length))
