"""The page a film is drawn on: axes, colour bar and titles once, force curves and text as they change."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image, ImageDraw, ImageFont

from taichi_silo.runs.point_fields import Scale
from taichi_silo.show.film.colour_bar import draw_scale
from taichi_silo.show.film.strokes import blend, stroke
from taichi_silo.show.report.words import length_unit

SIZE = (1920, 1080)  # of the page as it is laid out; others are scaled, and stand in the middle of what is left white
INK, GREY = (34, 34, 34), (105, 105, 105)
BACKGROUND, MISSING = (243, 243, 243), (190, 190, 190)  # no sand; sand without a value
# Okabe-Ito colours, told apart by colour-blind viewers
FORCES = (
    ("P", "bottom", (0, 114, 178)),
    ("T", "wall friction", (213, 94, 0)),
    ("N", "wall normal", (0, 158, 115)),
)
WALL = 10  # thickness of a drawn wall
RIGHT = 1835  # right end of the force axes; beyond it only the labels of the curves
FONTS = Path(matplotlib.get_data_path()) / "fonts" / "ttf"


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


def font(size: float, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Return matplotlib's bundled DejaVu Sans, `size` in pixels."""
    return ImageFont.truetype(str(FONTS / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")), size)


class Course(NamedTuple):
    """What the curves are drawn against.

    Attributes
    ----------
    end : where the axis ends, in its own SI unit (m or s).
    label, caption : of the axis and of the reading.
    unit, scale, digits : shown unit, its number in an SI unit, decimals of the reading.

    """

    end: float
    label: str = "bottom displacement u (mm)"
    caption: str = "displacement u"
    unit: str = "mm"
    scale: float = 1e3
    digits: int = 2


class Canvas:
    """Lays out a page for one silo and keeps its force curves; lengths in m, forces in N/m.

    `panel` is the Box where the sand goes: exactly wall to wall, its top row at height `top_m`, the same
    `pixels_per_metre` along both axes, and deep enough for the bottom plate when it has sunk by `sinks_m`. Lengths on
    the page are those of 1920 columns and 1080 rows, times `zoom`.
    """

    def __init__(
        self,
        width_m: float,
        height_m: float,
        weight_N_per_m: float,
        scale: Scale,
        title: str,
        course: Course,
        sinks_m: float,
        size: tuple[int, int] = SIZE,
    ):
        self.size, self.course = size, course
        self.zoom = min(size[0] / SIZE[0], size[1] / SIZE[1])
        self.corner = [round(0.5 * (have - self.zoom * need)) for have, need in zip(size, SIZE, strict=True)]
        self.top_force = 1.1 * weight_N_per_m
        self.plate_m = 0.02 * max(height_m, width_m)
        self.top_m = 1.015 * height_m
        depth = self.top_m + sinks_m + self.plate_m
        columns = self._long(width_m * min(870 / depth, 480 / width_m))
        self.pixels_per_metre = columns / width_m
        rows = max(1, round(depth * self.pixels_per_metre))
        self.panel = Box(self._x(170), self._y(545) - rows // 2, columns, rows)
        left = self.panel.left + columns + self._long(385)
        self.plot = Box(left, self._y(310), self._x(RIGHT) - left, self._long(670))
        self._value_font = font(36 * self.zoom, bold=True)
        self.background = self._furniture(width_m, height_m, weight_N_per_m, scale, title)
        self._bare_plot = self.background[self.plot.slices].copy()
        self._coverage = np.zeros((len(FORCES), self.plot.rows, self.plot.columns), np.float32)
        self._drawn: np.ndarray | None = None  # (3, 2) where each curve ends so far, pixels of the plot
        self._tip: np.ndarray | None = None  # (3, 2) the newest points, pixels of the plot
        self._forces = np.full(len(FORCES), np.nan)
        # four digits at most: the readings must fit their columns
        self._decimals = int(np.clip(3 - np.floor(np.log10(1e-3 * weight_N_per_m)), 0, 3))

    def _long(self, length: float) -> int:
        """A length of the layout in pixels."""
        return max(1, round(self.zoom * length))

    def _x(self, place: float) -> int:
        return self.corner[0] + round(self.zoom * place)

    def _y(self, place: float) -> int:
        return self.corner[1] + round(self.zoom * place)

    def _furniture(self, width_m, height_m, weight, scale, title) -> np.ndarray:
        """Draw all that never changes; return the page (rows, columns, 3) of bytes."""
        panel, plot = self.panel, self.plot
        dots = 72 * self.zoom  # to the inch: one point of matplotlib is one pixel of the layout
        figure = Figure(figsize=(self.size[0] / dots, self.size[1] / dots), dpi=dots, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        ink = tuple(channel / 255 for channel in INK)
        look: dict[str, Any] = {"labelsize": 26, "length": 8, "width": 2, "color": ink, "labelcolor": ink}

        silo = figure.add_axes(panel.fractions(self.size))
        bottom_m = self.top_m - panel.rows / self.pixels_per_metre
        unit, per_m = length_unit(height_m)
        silo.set(xlim=(0, per_m * width_m), ylim=(per_m * bottom_m, per_m * self.top_m), facecolor="#f3f3f3")
        silo.set_xlabel(f"x ({unit})", fontsize=28, color=ink)
        silo.set_ylabel(f"y ({unit})", fontsize=28, color=ink)
        wide = round(panel.columns / self.zoom)
        silo.xaxis.set_major_locator(MaxNLocator(min(4, 1 + wide // 100), steps=[1, 2, 5, 10]))
        silo.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        silo.spines[:].set_visible(False)
        for side in ("left", "bottom"):
            silo.spines[side].set_position(("outward", WALL))
        silo.tick_params(**look)

        rows = max(round(0.62 * panel.rows), self._long(300))
        top = panel.top + (panel.rows - rows) // 2
        bar = Box(panel.left + panel.columns + self._long(70), top, self._long(36), rows)
        draw_scale(figure.add_axes(bar.fractions(self.size)), scale, look, np.array(MISSING) / 255)

        forces = figure.add_axes(plot.fractions(self.size))
        forces.set(xlim=(0, self.course.scale * self.course.end), ylim=(0, 1e-3 * self.top_force))
        forces.set_xlabel(self.course.label, fontsize=28, color=ink)
        forces.set_ylabel("force per metre (kN/m)", fontsize=30, color=ink, labelpad=12)
        forces.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
        forces.grid(color="#e4e4e4", linewidth=2)
        forces.set_axisbelow(True)
        forces.spines[["top", "right"]].set_visible(False)
        forces.spines[["left", "bottom"]].set(linewidth=2, color=ink)
        forces.axhline(1e-3 * weight, color="#777777", linewidth=2.5, linestyle=(0, (6, 4)))
        forces.text(
            0.985, 1 / 1.1 - 0.015, f"weight of the sand {1e-3 * weight:.4g} kN/m",
            transform=forces.transAxes, fontsize=26, color="#555555", ha="right", va="top",
        )  # fmt: skip
        forces.tick_params(**look)
        canvas.draw()

        page = np.asarray(canvas.buffer_rgba())[..., :3].copy()
        wall = self._long(WALL)
        for left in (panel.left - wall, panel.left + panel.columns):
            page[panel.top : panel.top + panel.rows, left : left + wall] = INK
        return self._captions(page, title)

    def _captions(self, page: np.ndarray, title: str) -> np.ndarray:
        """Write the title and the names of the readings on the page."""
        image = Image.fromarray(page)
        draw = ImageDraw.Draw(image)
        size = 42
        while size > 24 and draw.textlength(title, font(size * self.zoom, bold=True)) > self.zoom * (SIZE[0] - 120):
            size -= 1
        draw.text((self._x(60), self._y(50)), title, INK, font(size * self.zoom, bold=True), anchor="lm")
        self._readings = [(x, self._y(y)) for y in (166, 266) for x in self._columns()]
        captions = [("stage", GREY), ("time", GREY), (self.course.caption, GREY)]
        captions += [(f"{letter}  {name}", colour) for letter, name, colour in FORCES]
        for (x, y), (caption, colour) in zip(self._readings, captions, strict=True):
            draw.text((x, y - self._long(40)), caption, colour, font(27 * self.zoom), anchor="ls")
        return np.array(image)

    def _columns(self) -> list[int]:
        """Left ends of the three columns of readings, pixels."""
        return [self.plot.left + round(k * (self._x(RIGHT) - self.plot.left) / 3) for k in range(3)]

    def add_forces(self, progress: float, forces_N_per_m: np.ndarray) -> None:
        """Extend the three curves to a new row: P, T, N, shape (3,), N/m, at a place of the course (m or s).

        Up to 0 the points only move. Steps under a pixel wait until they add up to one.
        """
        forces = np.asarray(forces_N_per_m, dtype=float)
        if not (np.isfinite(progress) and np.isfinite(forces).all()):
            return
        x = (self.plot.columns - 1) * max(progress, 0.0) / self.course.end
        y = (self.plot.rows - 1) * (1.0 - forces / self.top_force)
        # far outside the axes a curve runs along just beyond their edge
        y = np.clip(y, -50, self.plot.rows + 50)
        self._forces, self._tip = forces, np.stack((np.full(3, x), y), axis=1)
        if self._drawn is None or progress <= 0.0:
            self._drawn = self._tip.copy()
            return
        for k in np.flatnonzero(np.hypot(*(self._tip - self._drawn).T) >= 1.0):
            window, cover = stroke(self._coverage.shape[1:], self._drawn[k], self._tip[k], 2.75 * self.zoom)
            layer = self._coverage[k][window]
            np.maximum(layer, cover, out=layer)
            # repaint the window from the bare plot, so that smooth edges do not darken where strokes overlap
            view = self.background[self.plot.slices][window]
            view[...] = self._bare_plot[window]
            for (_, _, colour), coverage in zip(FORCES, self._coverage, strict=True):
                blend(view, coverage[window], colour)
            self._drawn[k] = self._tip[k]

    def page(self, time_s: float, stage: str, progress: float) -> np.ndarray:
        """Return a new frame (rows, columns, 3) of bytes, all but the sand; time in s, displacement in m."""
        frame = self.background.copy()
        course = self.course
        texts = [stage, f"{time_s:.3f} s", f"{course.scale * progress:.{course.digits}f} {course.unit}"]
        for force in self._forces:
            texts.append(f"{1e-3 * force:.{self._decimals}f} kN/m" if np.isfinite(force) else "–")
        left, top = self.plot.left, self._y(130)
        band = frame[top : self._y(280), left : self._x(SIZE[0])]
        image = Image.fromarray(band)
        draw = ImageDraw.Draw(image)
        for (x, y), text in zip(self._readings, texts, strict=True):
            draw.text((x - left, y - top), text, INK, self._value_font, anchor="ls")
        band[...] = np.asarray(image)
        if self._tip is not None:
            self._mark_tips(frame, self._tip)
        return frame

    def _mark_tips(self, frame: np.ndarray, newest: np.ndarray) -> None:
        """Put a dot with the curve's letter at each newest point, the letters kept apart from each other."""
        tips = newest + (self.plot.left, self.plot.top)
        tips[:, 1] = np.clip(tips[:, 1], self.plot.top, self.plot.top + self.plot.rows - 1)
        for tip, (_, _, colour) in zip(tips, FORCES, strict=True):
            for radius, fill in ((11.0, (255, 255, 255)), (8.0, colour)):
                window, cover = stroke(frame.shape[:2], tip, tip, radius * self.zoom)
                blend(frame[window], cover, fill)
        order = np.argsort(tips[:, 1])
        gap, room = self._long(36), self._long(30)
        heights = tips[order, 1]
        heights[1] = max(heights[1], heights[0] + gap)
        heights[2] = max(heights[2], heights[1] + gap)
        heights += np.mean(tips[order, 1] - heights)  # spread to both sides of the crowded points
        left = round(tips[0, 0]) + self._long(16)
        top = int(np.clip(heights[0] - room, 0, frame.shape[0] - 2 * room))
        strip = frame[top : min(frame.shape[0], int(heights[2]) + room), left : left + self._long(50)]
        image = Image.fromarray(strip)
        draw = ImageDraw.Draw(image)
        for height, k in zip(heights, order, strict=True):
            letter, _, colour = FORCES[k]
            where = (self._long(4), height - top)
            draw.text(where, letter, colour, self._value_font, "lm", stroke_width=self._long(3), stroke_fill="white")
        strip[...] = np.asarray(image)
