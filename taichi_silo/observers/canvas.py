"""The page a film is drawn on: axes, colour bar and titles once, force curves and text as they change."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image, ImageDraw, ImageFont

WIDTH, HEIGHT = 1920, 1080
COLOUR_MAP = "viridis"
INK, GREY = (34, 34, 34), (105, 105, 105)
# Okabe-Ito colours, told apart by colour-blind viewers
FORCES = (
    ("P", "bottom", (0, 114, 178)),
    ("T", "wall friction", (213, 94, 0)),
    ("N", "wall normal", (0, 158, 115)),
)
WALL = 10  # thickness of a drawn wall, pixels
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

    @property
    def fractions(self) -> tuple[float, float, float, float]:
        """Left, bottom, width and height in fractions of the page, as matplotlib counts them."""
        bottom = HEIGHT - self.top - self.rows
        return self.left / WIDTH, bottom / HEIGHT, self.columns / WIDTH, self.rows / HEIGHT


def font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Return matplotlib's bundled DejaVu Sans, `size` in pixels."""
    return ImageFont.truetype(str(FONTS / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")), size)


def stroke(shape: tuple[int, int], start: np.ndarray, end: np.ndarray, half_width: float):
    """Return the window (two slices) of an image and a round-ended line's smooth coverage (0 to 1) in it.

    `shape` is (rows, columns); `start` and `end` are (x, y) in pixels. Equal ends give a disc.
    """
    low = np.floor(np.minimum(start, end) - half_width - 1).astype(int)
    high = np.ceil(np.maximum(start, end) + half_width + 2).astype(int)
    (x0, y0), (x1, y1) = np.clip(low, 0, shape[::-1]), np.clip(high, 0, shape[::-1])
    y, x = np.ogrid[y0:y1, x0:x1]
    along = end - start
    share = ((x - start[0]) * along[0] + (y - start[1]) * along[1]) / max(along @ along, 1e-12)
    share = np.clip(share, 0.0, 1.0)
    distance = np.hypot(x - start[0] - share * along[0], y - start[1] - share * along[1])
    return (slice(y0, y1), slice(x0, x1)), np.clip(half_width + 0.5 - distance, 0.0, 1.0).astype(np.float32)


def blend(image: np.ndarray, coverage: np.ndarray, colour: tuple[int, int, int]) -> None:
    """Lay `colour` over `image` (rows, columns, 3) of bytes, weighted by `coverage` (rows, columns)."""
    weight = coverage[..., None]
    image[...] = np.rint(image * (1 - weight) + weight * np.asarray(colour, np.float32)).astype(np.uint8)


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
    """Lays out a 1920x1080 page for one silo and keeps its force curves; lengths in m, forces in N/m.

    `panel` is the Box where the sand goes: exactly wall to wall, its top row at height `top_m`, the same
    `pixels_per_metre` along both axes, and deep enough for the bottom plate when it has sunk by `sinks_m` (the final
    displacement if absent).
    """

    def __init__(
        self,
        width_m: float,
        height_m: float,
        displacement_m: float,
        weight_N_per_m: float,
        void_ratio_range: tuple[float, float],
        title: str,
        course: Course | None = None,
        sinks_m: float | None = None,
    ):
        self.course = course or Course(displacement_m)
        self.top_force = 1.1 * weight_N_per_m
        self.plate_m = 0.02 * max(height_m, width_m)
        self.top_m = 1.015 * height_m
        depth = self.top_m + (displacement_m if sinks_m is None else sinks_m) + self.plate_m
        columns = max(1, round(width_m * min(870 / depth, 480 / width_m)))
        self.pixels_per_metre = columns / width_m
        rows = max(1, round(depth * self.pixels_per_metre))
        self.panel = Box(170, 545 - rows // 2, columns, rows)
        left = self.panel.left + columns + 385
        self.plot = Box(left, 310, RIGHT - left, 670)
        self.background = self._furniture(width_m, weight_N_per_m, void_ratio_range, title)
        self._bare_plot = self.background[self.plot.slices].copy()
        self._coverage = np.zeros((len(FORCES), self.plot.rows, self.plot.columns), np.float32)
        self._drawn: np.ndarray | None = None  # (3, 2) where each curve ends so far, pixels of the plot
        self._tip: np.ndarray | None = None  # (3, 2) the newest points, pixels of the plot
        self._forces = np.full(len(FORCES), np.nan)
        # four digits at most: the readings must fit their columns
        self._decimals = int(np.clip(3 - np.floor(np.log10(1e-3 * weight_N_per_m)), 0, 3))

    def _furniture(self, width_m, weight, void_ratio_range, title) -> np.ndarray:
        """Draw all that never changes; return the page (1080, 1920, 3) of bytes."""
        panel, plot = self.panel, self.plot
        # 72 dots per inch: one matplotlib point is one pixel
        figure = Figure(figsize=(WIDTH / 72, HEIGHT / 72), dpi=72, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        ink = tuple(channel / 255 for channel in INK)
        look = {"labelsize": 26, "length": 8, "width": 2, "color": ink, "labelcolor": ink}

        silo = figure.add_axes(panel.fractions)
        bottom_m = self.top_m - panel.rows / self.pixels_per_metre
        silo.set(xlim=(0, 1e3 * width_m), ylim=(1e3 * bottom_m, 1e3 * self.top_m), facecolor="#f3f3f3")
        silo.set_xlabel("x (mm)", fontsize=28, color=ink)
        silo.set_ylabel("y (mm)", fontsize=28, color=ink)
        silo.xaxis.set_major_locator(MaxNLocator(min(4, 1 + panel.columns // 100), steps=[1, 2, 5, 10]))
        silo.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        silo.spines[:].set_visible(False)
        for side in ("left", "bottom"):
            silo.spines[side].set_position(("outward", WALL))
        silo.tick_params(**look)

        rows = max(round(0.62 * panel.rows), 300)
        bar_box = Box(panel.left + panel.columns + 70, panel.top + (panel.rows - rows) // 2, 36, rows)
        colours = ScalarMappable(Normalize(*void_ratio_range), COLOUR_MAP)
        bar = figure.colorbar(colours, cax=figure.add_axes(bar_box.fractions))
        bar.set_label("void ratio e", fontsize=30, color=ink, labelpad=12)
        bar.locator = MaxNLocator(6, steps=[1, 2, 5, 10])
        bar.outline.set_visible(False)
        bar.ax.tick_params(**look)
        for height, word, align in ((1.02, "loose", "bottom"), (-0.02, "dense", "top")):
            bar.ax.text(0.5, height, word, transform=bar.ax.transAxes, fontsize=26, ha="center", va=align)

        forces = figure.add_axes(plot.fractions)
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
        for wall in (panel.left - WALL, panel.left + panel.columns):
            page[panel.top : panel.top + panel.rows, wall : wall + WALL] = INK
        return self._captions(page, title)

    def _captions(self, page: np.ndarray, title: str) -> np.ndarray:
        """Write the title and the names of the readings on the page."""
        image = Image.fromarray(page)
        draw = ImageDraw.Draw(image)
        size = 42
        while size > 24 and draw.textlength(title, font(size, bold=True)) > WIDTH - 120:
            size -= 1
        draw.text((60, 50), title, INK, font(size, bold=True), anchor="lm")
        self._readings = [(x, y) for y in (166, 266) for x in self._columns()]
        captions = [("stage", GREY), ("time", GREY), (self.course.caption, GREY)]
        captions += [(f"{letter}  {name}", colour) for letter, name, colour in FORCES]
        for (x, y), (caption, colour) in zip(self._readings, captions, strict=True):
            draw.text((x, y - 40), caption, colour, font(27), anchor="ls")
        return np.array(image)

    def _columns(self) -> list[int]:
        """Left ends of the three columns of readings, pixels."""
        return [self.plot.left + round(k * (RIGHT - self.plot.left) / 3) for k in range(3)]

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
            window, cover = stroke(self._coverage.shape[1:], self._drawn[k], self._tip[k], 2.75)
            layer = self._coverage[k][window]
            np.maximum(layer, cover, out=layer)
            # repaint the window from the bare plot, so that smooth edges do not darken where strokes overlap
            view = self.background[self.plot.slices][window]
            view[...] = self._bare_plot[window]
            for (_, _, colour), coverage in zip(FORCES, self._coverage, strict=True):
                blend(view, coverage[window], colour)
            self._drawn[k] = self._tip[k]

    def page(self, time_s: float, stage: str, progress: float) -> np.ndarray:
        """Return a new frame (1080, 1920, 3) of bytes, all but the sand; time in s, displacement in m."""
        frame = self.background.copy()
        course = self.course
        texts = [stage, f"{time_s:.3f} s", f"{course.scale * progress:.{course.digits}f} {course.unit}"]
        for force in self._forces:
            texts.append(f"{1e-3 * force:.{self._decimals}f} kN/m" if np.isfinite(force) else "–")
        corner, opposite = (self.plot.left, 130), (WIDTH, 280)
        band = frame[corner[1] : opposite[1], corner[0] : opposite[0]]
        image = Image.fromarray(band)
        draw = ImageDraw.Draw(image)
        for (x, y), text in zip(self._readings, texts, strict=True):
            draw.text((x - corner[0], y - corner[1]), text, INK, self._value_font, anchor="ls")
        band[...] = np.asarray(image)
        if self._tip is not None:
            self._mark_tips(frame)
        return frame

    _value_font = font(36, bold=True)

    def _mark_tips(self, frame: np.ndarray) -> None:
        """Put a dot with the curve's letter at each newest point, the letters kept apart from each other."""
        tips = self._tip + (self.plot.left, self.plot.top)
        tips[:, 1] = np.clip(tips[:, 1], self.plot.top, self.plot.top + self.plot.rows - 1)
        for tip, (_, _, colour) in zip(tips, FORCES, strict=True):
            for radius, fill in ((11.0, (255, 255, 255)), (8.0, colour)):
                window, cover = stroke((HEIGHT, WIDTH), tip, tip, radius)
                blend(frame[window], cover, fill)
        order = np.argsort(tips[:, 1])
        gap = 36
        heights = tips[order, 1]
        heights[1] = max(heights[1], heights[0] + gap)
        heights[2] = max(heights[2], heights[1] + gap)
        heights += np.mean(tips[order, 1] - heights)  # spread to both sides of the crowded points
        left = round(tips[0, 0]) + 16
        top = int(np.clip(heights[0] - 30, 0, HEIGHT - 60))
        strip = frame[top : min(HEIGHT, int(heights[2]) + 30), left : left + 50]
        image = Image.fromarray(strip)
        draw = ImageDraw.Draw(image)
        for height, k in zip(heights, order, strict=True):
            letter, _, colour = FORCES[k]
            where = (4, height - top)
            draw.text(where, letter, colour, self._value_font, "lm", stroke_width=3, stroke_fill="white")
        strip[...] = np.asarray(image)
