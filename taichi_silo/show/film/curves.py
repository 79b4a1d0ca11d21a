"""The force curves of a page, as they grow: P, T and N against the course of the run."""

from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw

from taichi_silo.show.film.layout import Layout
from taichi_silo.show.film.lettering import font
from taichi_silo.show.film.strokes import blend, stroke

# Okabe-Ito colours, told apart by colour-blind viewers
FORCES = (
    ("P", "bottom", (0, 114, 178)),
    ("T", "wall friction", (213, 94, 0)),
    ("N", "wall normal", (0, 158, 115)),
)
LIGHT = 0.25  # weight of a band's colour
HALF_WIDTH = 2.75  # of a curve
LOWEST = 22  # place of the middle of a letter above the axis: half its height, and its rim


class Course(NamedTuple):
    """What the curves are drawn against.

    Attributes
    ----------
    end : where the axis ends, in its own SI unit (m or s).
    label, caption : of the axis and of the reading.
    unit, scale, digits : shown unit, its number in an SI unit, decimals of the reading.
    per : what forces are per.

    """

    end: float
    label: str = "bottom displacement u (mm)"
    caption: str = "displacement u"
    unit: str = "mm"
    scale: float = 1e3
    digits: int = 2
    per: str = "metre run"


class Curves:
    """Draws into the part of a page where the curves are.

    Parameters
    ----------
    layout : of the page.
    page : (rows, columns, 3) of bytes with all that never changes; the curves are laid over it.
    end : of the course [m or s].
    top_force : upper end of the axis [N/m].

    """

    def __init__(self, layout: Layout, page: np.ndarray, end: float, top_force: float):
        self.layout, self.end, self.top_force = layout, end, top_force
        assert layout.plot is not None
        self.plot, self.shown = layout.plot, page[layout.plot.slices]
        self.bare = self.shown.copy()
        shape = len(FORCES), self.plot.rows, self.plot.columns
        self.coverage, self.bands = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
        self.drawn: np.ndarray | None = None  # (3, 2) where each curve ends so far, pixels of the plot
        self.tip: np.ndarray | None = None  # (3, 2) the newest points, pixels of the plot
        self.spread: np.ndarray | None = None  # (3, 2) rows of the band's lower and upper end there
        self.forces = np.full(len(FORCES), np.nan)
        self.rows: list[tuple[float, np.ndarray, np.ndarray | None]] = []  # of what has been added with the flow

    def add(self, progress: float, forces: np.ndarray, spread: np.ndarray | None = None) -> None:
        """Extend the curves to a new row: P, T, N (3,) [N/m] at a place of the course [m or s].

        Up to 0 the points only move. Steps under a pixel wait until they add up to one.

        Parameters
        ----------
        progress : the place.
        forces : that the curves show.
        spread : (3, 2) lower and upper end of a light band around them.

        """
        if not (np.isfinite(progress) and np.isfinite(forces).all()):
            return
        x = (self.plot.columns - 1) * max(progress, 0.0) / self.end
        self.forces, self.tip = forces, np.stack((np.full(3, x), self._row(forces)), axis=1)
        if progress > 0.0:
            self.rows.append((progress, forces, spread))
        edges = None if spread is None else self._row(spread)
        if self.drawn is None or progress <= 0.0:
            self.drawn, self.spread = self.tip.copy(), edges
            return
        for k in np.flatnonzero(np.hypot(*(self.tip - self.drawn).T) >= 1.0):
            self._extend(int(k), edges)

    def _row(self, forces: np.ndarray) -> np.ndarray:
        """Rows of the plot; far outside the axes a curve runs along just beyond their edge."""
        return np.clip((self.plot.rows - 1) * (1.0 - forces / self.top_force), -50, self.plot.rows + 50)

    def _extend(self, k: int, edges: np.ndarray | None) -> None:
        """Draw a piece of one curve, and of its band."""
        assert self.drawn is not None and self.tip is not None
        window, cover = stroke(self.coverage.shape[1:], self.drawn[k], self.tip[k], HALF_WIDTH * self.layout.zoom)
        layer = self.coverage[k][window]
        np.maximum(layer, cover, out=layer)
        if edges is not None:
            first, last = (int(np.clip(end[k, 0], 0, self.plot.columns - 1)) for end in (self.drawn, self.tip))
            low, high = np.clip(np.rint(edges[k]).astype(int), 0, self.plot.rows)
            self.bands[k, high:low, first : last + 1] = LIGHT
            window = slice(0, self.plot.rows), slice(min(first, window[1].start), max(last + 1, window[1].stop))
        # repaint the window from the bare plot, so that smooth edges do not darken where strokes overlap
        view = self.shown[window]
        view[...] = self.bare[window]
        for layers in (self.bands, self.coverage) if edges is not None or self.bands.any() else (self.coverage,):
            for (_, _, colour), layer in zip(FORCES, layers, strict=True):
                blend(view, layer[window], colour)
        self.drawn[k] = self.tip[k]

    def mark_tips(self, frame: np.ndarray) -> None:
        """Put a dot with the curve's letter at each newest point, the letters kept apart from each other."""
        if self.tip is None:
            return
        layout, plot = self.layout, self.plot
        tips = self.tip + (plot.left, plot.top)
        tips[:, 1] = np.clip(tips[:, 1], plot.top, plot.top + plot.rows - 1)
        for tip, (_, _, colour) in zip(tips, FORCES, strict=True):
            for radius, fill in ((11.0, (255, 255, 255)), (8.0, colour)):
                window, cover = stroke(frame.shape[:2], tip, tip, radius * layout.zoom)
                blend(frame[window], cover, fill)
        order, room = np.argsort(tips[:, 1]), layout.long(30)
        heights = apart(tips[order, 1], layout.long(36), plot.top + plot.rows - layout.long(LOWEST))
        left = round(tips[0, 0]) + layout.long(16)
        top = int(np.clip(heights[0] - room, 0, frame.shape[0] - 2 * room))
        strip = frame[top : min(frame.shape[0], int(heights[2]) + room), left : left + layout.long(50)]
        image = Image.fromarray(strip)
        draw = ImageDraw.Draw(image)
        letters = font(36 * layout.zoom, bold=True)
        for height, k in zip(heights, order, strict=True):
            where = (layout.long(4), height - top)
            draw.text(
                where, FORCES[k][0], FORCES[k][2], letters, "lm", stroke_width=layout.long(3), stroke_fill="white"
            )
        strip[...] = np.asarray(image)


def apart(heights: np.ndarray, gap: float, lowest: float) -> np.ndarray:
    """Three rows of a page, the topmost first, spread to both sides until they are a gap apart, and none too low."""
    found = heights.copy()
    found[1] = max(found[1], found[0] + gap)
    found[2] = max(found[2], found[1] + gap)
    found += np.mean(heights - found)
    return np.minimum(found, lowest - gap * np.array([2.0, 1.0, 0.0]))
