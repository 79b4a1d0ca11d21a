"""Points as filled cells of a picture."""

import matplotlib
import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image, ImageDraw

from taichi_silo.mpm.language import ti
from taichi_silo.show.film.furniture import MISSING
from taichi_silo.show.film.lettering import INK

BACKGROUND = (243, 243, 243)  # no sand
REACH = 0.75  # a point colours what lies within this many spacings of it, in x and in y
SAMPLES = 2  # samples per pixel along each axis
COLOURS = 256
EMPTY, PLATE, UNKNOWN = COLOURS, COLOURS + 1, COLOURS + 2  # further entries of the colour table
INDEX_BITS, UNCLAIMED = 31, 2**62


def table(colours: str | tuple[str, ...]) -> np.ndarray:
    """The colours (256, 3), 0 to 255, of a map of matplotlib, or of classes that share them evenly."""
    places = np.linspace(0.0, 1.0, COLOURS)
    if isinstance(colours, str):
        return np.rint(255 * matplotlib.colormaps[colours](places)[:, :3])
    chosen = np.rint(places * (len(colours) - 1)).astype(int)
    return np.rint(255 * np.array([to_rgb(colour) for colour in colours])[chosen])


def levels(share: np.ndarray) -> np.ndarray:
    """Entries of the colour table for places between the ends of a scale; nan is unknown."""
    known = np.isfinite(share)
    return np.where(known, np.rint((COLOURS - 1) * np.where(known, share, 0.0)), UNKNOWN).astype(np.int32)


@ti.data_oriented
class SandRaster:
    """Paints material points as filled cells: every sample takes the colour of its nearest point.

    A point competes only for the samples of a square around it (max-norm distance up to REACH spacings), so
    the outer edges of a block of points stay straight. Inside that square the nearest point is the Euclidean
    one: in the max-norm a stretched lattice has whole areas that are equally near to two points. Each point
    visits its own samples and the smallest (distance, index) key wins, which needs no neighbour search, has
    no capacity to overflow and gives the same image for any number of threads.

    Parameters
    ----------
    columns, rows : int
        Size of the image, pixels.
    pixels_per_metre : float
        Scale along both axes.
    top_m : float
        Height of the upper edge of row 0, m.
    spacing_m : float
        Nominal spacing of the points, m.
    colours : str or tuple of str
        Name of a map of matplotlib, or one colour for each class.
    solids : list of ndarray
        Outlines (n, 2) of what stands still and covers the sand, m.
    left_m : float
        Where column 0 begins, m.
    """

    def __init__(
        self, columns: int, rows: int, pixels_per_metre: float, top_m: float, spacing_m: float, colours="viridis",
        solids=(), left_m=0.0,
    ):  # fmt: skip
        self.columns, self.rows = columns, rows
        self.samples_per_metre = SAMPLES * pixels_per_metre
        self.top_m, self.left_m = top_m, left_m
        self.reach = max(REACH * spacing_m * self.samples_per_metre, 0.75)  # samples; none may fall between
        self.nearest = ti.field(ti.i64, shape=(SAMPLES * rows, SAMPLES * columns))
        self.nearest.from_numpy(np.full(self.nearest.shape, UNCLAIMED))
        self.table = ti.Vector.field(3, ti.i32, shape=COLOURS + 3)
        self.table.from_numpy(np.vstack((table(colours), BACKGROUND, INK, MISSING)).astype(np.int32))
        self.image = np.zeros((rows, columns, 3), np.uint8)
        mask = Image.new("1", (SAMPLES * columns, SAMPLES * rows))
        for outline in solids:
            x, y = (outline[:, 0] - left_m) * self.samples_per_metre, (top_m - outline[:, 1]) * self.samples_per_metre
            ImageDraw.Draw(mask).polygon([*zip(x.tolist(), y.tolist(), strict=True)], fill=1)
        self.solid = ti.field(ti.i8, shape=self.nearest.shape)
        self.solid.from_numpy(np.asarray(mask).astype(np.int8))

    def see_through(self, position: np.ndarray, level: np.ndarray, *plate: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the image without its background, and how much each pixel covers (0 to 1), as `draw` would have both.

        The picture is drawn on black and on white: what differs is background.
        """
        found = []
        for shade in (0, 255):
            self.table[EMPTY] = [shade] * 3
            found.append(self.draw(position, level, *plate).astype(float))
        self.table[EMPTY] = list(BACKGROUND)
        cover = 1.0 - np.clip((found[1] - found[0]).mean(axis=2) / 255.0, 0.0, 1.0)
        colour = found[0] / np.maximum(cover, 1e-9)[..., None]
        return np.rint(np.clip(colour, 0.0, 255.0)).astype(np.uint8), cover

    def draw(self, position: np.ndarray, level: np.ndarray, plate_top_m: float, plate_bottom_m: float) -> np.ndarray:
        """Return the image (rows, columns, 3) of bytes, valid until the next call.

        `position` is (n, 2) in m, `level` (n,) the entry of the colour table; the bottom plate, between
        the two heights in m, covers the sand, and below it nothing is drawn.
        """
        position = np.ascontiguousarray(position, np.float64)
        if len(position):
            self._claim(position)
        else:  # a kernel cannot take an empty array, yet no sample is claimed
            level = np.zeros(1, np.int32)
        top, bottom = ((self.top_m - y) * self.samples_per_metre for y in (plate_top_m, plate_bottom_m))
        self._resolve(np.ascontiguousarray(level, np.int32), self.image, top, bottom)
        return self.image

    @ti.kernel
    def _claim(self, position: ti.types.ndarray()):  # type: ignore[valid-type]
        for p in range(position.shape[0]):
            x = (position[p, 0] - self.left_m) * self.samples_per_metre - 0.5
            y = (self.top_m - position[p, 1]) * self.samples_per_metre - 0.5
            first = ti.max(ti.cast(ti.ceil(x - self.reach), ti.i32), 0)
            last = ti.min(ti.cast(ti.floor(x + self.reach), ti.i32), SAMPLES * self.columns - 1)
            upper = ti.max(ti.cast(ti.ceil(y - self.reach), ti.i32), 0)
            lower = ti.min(ti.cast(ti.floor(y + self.reach), ti.i32), SAMPLES * self.rows - 1)
            scale = 2.0**28 / (self.reach * self.reach)
            for i in range(upper, lower + 1):
                for j in range(first, last + 1):
                    square = (j - x) ** 2 + (i - y) ** 2
                    # squared distance in the high bits, index in the low ones
                    key = (ti.cast(square * scale, ti.i64) << INDEX_BITS) | p
                    if key < self.nearest[i, j]:  # spares most of the atomics
                        ti.atomic_min(self.nearest[i, j], key)

    @ti.kernel
    def _resolve(
        self,
        level: ti.types.ndarray(),  # type: ignore[valid-type]
        image: ti.types.ndarray(),  # type: ignore[valid-type]
        top: ti.f64,
        bottom: ti.f64,
    ):
        """Average the samples of every pixel and release them for the next frame."""
        for i, j in ti.ndrange(self.rows, self.columns):
            colour = ti.Vector([0, 0, 0])
            for a, b in ti.static(ti.ndrange(SAMPLES, SAMPLES)):
                row, column = SAMPLES * i + a, SAMPLES * j + b
                key = self.nearest[row, column]
                self.nearest[row, column] = ti.i64(UNCLAIMED)
                entry = EMPTY
                if self.solid[row, column] > 0:
                    entry = PLATE
                elif row + 0.5 >= top:
                    if row + 0.5 < bottom:
                        entry = PLATE
                elif key < ti.i64(UNCLAIMED):
                    entry = level[ti.cast(key & 0x7FFFFFFF, ti.i32)]
                colour += self.table[entry]
            for channel in ti.static(range(3)):
                mean = (colour[channel] + SAMPLES * SAMPLES // 2) // (SAMPLES * SAMPLES)
                image[i, j, channel] = ti.cast(mean, ti.u8)
