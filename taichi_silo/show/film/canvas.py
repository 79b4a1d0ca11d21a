"""The page a film is drawn on: axes, colour bar and titles once, force curves and text as they change."""

from __future__ import annotations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image, ImageDraw

from taichi_silo.runs.point_fields import Scale
from taichi_silo.show.film.curves import FORCES, Course, Curves
from taichi_silo.show.film.furniture import furniture
from taichi_silo.show.film.layout import WALL, Box, Layout, View
from taichi_silo.show.film.lettering import GREY, INK, fitting, font, title_lines

HEADROOM = 1.1  # upper end of the axis of forces, times the weight or the largest force
READING, CAPTION = 36, 27  # sizes of the letters


class Canvas:
    """Keeps the page of one run; lengths in m, forces in N/m.

    Parameters
    ----------
    layout : of the page.
    view : what is seen of the silo.
    walls : heights between which the left and the right side of the view are walls.
    weight_N_per_m : of the sand; of the heavier one of two runs beside each other.
    largest_N_per_m : force that the curves reach.
    scale : of the colours.
    title : above everything.
    course : what the curves are drawn against.
    note : what the curves are, if there is something to say.

    """

    def __init__(
        self, layout: Layout, view: View, walls: tuple[list[tuple[float, float]], ...], weight_N_per_m: float,
        scale: Scale, title: str, course: Course, note: str = "", largest_N_per_m: float = 0.0,
    ):  # fmt: skip
        self.layout, self.view, self.walls, self.course = layout, view, walls, course
        self.panel, self.plot = layout.panel, layout.plot
        self.top_force, self.title = HEADROOM * max(weight_N_per_m, largest_N_per_m), title
        self.furniture = furniture(layout, view, weight_N_per_m, scale, course, self.top_force, note)
        self.background = self._captions(self._walls(self._page()))
        # four digits at most: the readings must fit their columns
        self._decimals = int(np.clip(3 - np.floor(np.log10(1e-3 * weight_N_per_m)), 0, 3))
        self.curves = Curves(layout, self.background, course.end, self.top_force) if layout.plot else None
        self._value_font = font(self.letters * layout.zoom, bold=True)

    def _page(self) -> np.ndarray:
        """The page (rows, columns, 3) of bytes with the furniture."""
        canvas = FigureCanvasAgg(self.furniture.figure)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()

    def _walls(self, page: np.ndarray) -> np.ndarray:
        for box in self.wall_boxes():
            page[box.top : box.top + box.rows, max(box.left, 0) : box.left + box.columns] = INK
        return page

    def wall_boxes(self) -> list[Box]:
        """Where walls stand beside the sand."""
        panel, wall, found = self.panel, self.layout.long(WALL), []
        for left, parts in zip((panel.left - wall, panel.left + panel.columns), self.walls, strict=True):
            for part in parts:
                low, high = (np.clip((self.view.top - y) * self.layout.pixels_per_metre, 0, panel.rows) for y in part)
                top, bottom = round(float(high)), round(float(low))
                found.append(Box(left, panel.top + top, wall, bottom - top))
        return found

    @property
    def letters(self) -> float:
        """Size of the readings: the widest fits its column."""
        places = sorted({x for x, _ in self.layout.readings})
        room = places[1] - places[0] if places else 1e9
        return fitting("0.000 kN/m", READING, self.layout.zoom, 0.98 * room, bold=True)

    def title_lines(self) -> list[tuple[float, str, float]]:
        """Height of the middle [lengths of the layout], text and size of each line of the title."""
        lines, size = title_lines(self.title, self.layout.zoom, self.layout.size[0] / self.layout.zoom - 120)
        middles = (50,) if len(lines) == 1 else (32, 32 + 1.25 * size)
        return [(middle, line, size) for middle, line in zip(middles, lines, strict=True)]

    def captions(self) -> list[tuple[int, int, str, tuple, float]]:
        """Place, text, colour and size of the name of each reading."""
        if not self.layout.readings:
            return []
        zoom, up = self.layout.zoom, self.layout.long(40)
        named = [("stage", GREY), ("time", GREY), (self.course.caption, GREY)]
        named += [(f"{letter}  {name}", colour) for letter, name, colour in FORCES]
        places = sorted({x for x, _ in self.layout.readings})
        size = min(fitting(text, CAPTION, zoom, 0.95 * (places[1] - places[0])) for text, _ in named)
        return [
            (x, y - up, text, colour, size) for (x, y), (text, colour) in zip(self.layout.readings, named, strict=True)
        ]

    def _captions(self, page: np.ndarray) -> np.ndarray:
        """Write the title and the names of the readings on the page."""
        if self.layout.plot is None:
            return page
        image, zoom = Image.fromarray(page), self.layout.zoom
        draw = ImageDraw.Draw(image)
        for middle, line, size in self.title_lines():
            draw.text((round(zoom * 60), round(zoom * middle)), line, INK, font(size * zoom, bold=True), anchor="lm")
        for x, y, text, colour, size in self.captions():
            draw.text((x, y), text, colour, font(size * zoom), anchor="ls")
        return np.array(image)

    def add_forces(self, progress: float, forces_N_per_m: np.ndarray, spread: np.ndarray | None = None) -> None:
        """Extend the curves to a new row: P, T, N (3,) [N/m] at a place of the course, and their band (3, 2)."""
        if self.curves:
            self.curves.add(progress, np.asarray(forces_N_per_m, dtype=float), spread)

    def texts(self, time_s: float, stage: str, progress: float) -> list[str]:
        """The readings."""
        course = self.course
        found = [stage, f"{time_s:.3f} s", f"{course.scale * progress:.{course.digits}f} {course.unit}"]
        for force in self.curves.forces if self.curves else ():
            found.append(f"{1e-3 * force:.{self._decimals}f} kN/m" if np.isfinite(force) else "–")
        return found

    def page(self, time_s: float, stage: str, progress: float) -> np.ndarray:
        """Return a new frame (rows, columns, 3) of bytes, all but the sand; time in s, displacement in m."""
        frame, places = self.background.copy(), self.layout.readings
        if self.curves is None:
            return frame
        left, top = min(x for x, _ in places), min(y for _, y in places) - self.layout.long(36)
        band = frame[top : max(y for _, y in places) + self.layout.long(14), left:]
        image = Image.fromarray(band)
        draw = ImageDraw.Draw(image)
        for (x, y), text in zip(places, self.texts(time_s, stage, progress), strict=True):
            draw.text((x - left, y - top), text, INK, self._value_font, anchor="ls")
        band[...] = np.asarray(image)
        self.curves.mark_tips(frame)
        return frame
