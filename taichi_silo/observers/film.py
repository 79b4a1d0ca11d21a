"""The film of a run: the sand coloured by its void ratio beside the force curves, encoded as it is drawn."""

import contextlib
import subprocess
import tempfile
from pathlib import Path

import imageio_ffmpeg
import matplotlib
import numpy as np
import taichi as ti
from PIL import Image, ImageDraw

from taichi_silo.observers.canvas import COLOUR_MAP, HEIGHT, INK, WIDTH, Canvas, Course
from taichi_silo.observers.segments import Segments

REACH = 0.75  # a point colours what lies within this many spacings of it, in x and in y
SAMPLES = 2  # samples per pixel along each axis
COLOURS = 256
EMPTY, PLATE = COLOURS, COLOURS + 1  # two more entries of the colour table
INDEX_BITS, UNCLAIMED = 31, 2**62
BACKGROUND = (243, 243, 243)


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
        Size of the image, pixels; its left edge is x = 0.
    pixels_per_metre : float
        Scale along both axes.
    top_m : float
        Height of the upper edge of row 0, m.
    spacing_m : float
        Nominal spacing of the points, m.
    solids : list of ndarray
        Outlines (n, 2) of what stands still and covers the sand, m.
    """

    def __init__(
        self, columns: int, rows: int, pixels_per_metre: float, top_m: float, spacing_m: float, solids=()
    ):  # fmt: skip
        self.columns, self.rows = columns, rows
        self.samples_per_metre = SAMPLES * pixels_per_metre
        self.top_m = top_m
        self.reach = max(REACH * spacing_m * self.samples_per_metre, 0.75)  # samples; none may fall between
        self.nearest = ti.field(ti.i64, shape=(SAMPLES * rows, SAMPLES * columns))
        self.nearest.from_numpy(np.full(self.nearest.shape, UNCLAIMED))
        self.table = ti.Vector.field(3, ti.i32, shape=COLOURS + 2)
        colours = np.rint(255 * matplotlib.colormaps[COLOUR_MAP](np.linspace(0, 1, COLOURS))[:, :3])
        self.table.from_numpy(np.vstack((colours, BACKGROUND, INK)).astype(np.int32))
        self.image = np.zeros((rows, columns, 3), np.uint8)
        mask = Image.new("1", (SAMPLES * columns, SAMPLES * rows))
        for outline in solids:
            x, y = outline[:, 0] * self.samples_per_metre, (top_m - outline[:, 1]) * self.samples_per_metre
            ImageDraw.Draw(mask).polygon([*zip(x.tolist(), y.tolist(), strict=True)], fill=1)
        self.solid = ti.field(ti.i8, shape=self.nearest.shape)
        self.solid.from_numpy(np.asarray(mask).astype(np.int8))

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
    def _claim(self, position: ti.types.ndarray()):
        for p in range(position.shape[0]):
            x = position[p, 0] * self.samples_per_metre - 0.5
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
    def _resolve(self, level: ti.types.ndarray(), image: ti.types.ndarray(), top: ti.f64, bottom: ti.f64):
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


class Encoder:
    """Feeds raw frames to ffmpeg under a temporary name; the film gets its final name when closed.

    Parameters
    ----------
    path : Path
        Where the film goes.
    frames_per_second : int
        Frame rate.
    """

    def __init__(self, path: Path, frames_per_second: int):
        self.path = path
        self.partial = path.with_name(f"{path.stem}.partial{path.suffix}")
        path.parent.mkdir(parents=True, exist_ok=True)
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the encoder
        # no frame refers to a later one (-bf 0): films can then be joined whatever their lengths are
        options = (
            f"-y -loglevel error -f rawvideo -pix_fmt rgb24 -s {WIDTH}x{HEIGHT} -r {frames_per_second} -i - "
            "-an -vf scale=out_color_matrix=bt709:out_range=tv,format=yuv420p "
            "-colorspace bt709 -color_primaries bt709 -color_trc bt709 "
            "-c:v libx264 -preset veryfast -crf 18 -bf 0 -threads 2 -movflags +faststart -f mp4"
        )
        command = [imageio_ffmpeg.get_ffmpeg_exe(), *options.split(), str(self.partial)]
        # own session: Ctrl-C stops the run, not the encoder, which then still completes its file
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            start_new_session=True,
        )
        self.frames = 0

    def write(self, frame: np.ndarray) -> None:
        """Append one frame, (1080, 1920, 3) of bytes; RuntimeError if ffmpeg has stopped."""
        try:
            self._process.stdin.write(memoryview(np.ascontiguousarray(frame)).cast("B"))
        except (BrokenPipeError, ValueError) as error:
            raise RuntimeError(f"ffmpeg stopped while writing {self.partial}: {self._complaint()}") from error
        self.frames += 1

    def _complaint(self) -> str:
        self._process.wait()
        if self._errors.closed:
            return "already closed"
        self._errors.seek(0)
        return self._errors.read().decode(errors="replace").strip()

    def close(self) -> None:
        """Finish the file and give it its final name; remove it if it holds no frame; RuntimeError if bad."""
        if self._process.stdin.closed:
            return
        with contextlib.suppress(BrokenPipeError):  # ffmpeg has gone; its exit code tells below
            self._process.stdin.close()
        complaint = self._complaint()
        self._errors.close()
        if self.frames == 0:
            self.partial.unlink(missing_ok=True)
        elif self._process.returncode == 0:
            self.partial.replace(self.path)
        else:
            raise RuntimeError(f"ffmpeg failed on {self.partial}: {complaint}")


class Film:
    """A 1920x1080 H.264 film of one run, drawn off screen; ti.init must have been called.

    The silo stands between x = 0 and x = `width_m`; its bottom plate starts at y = 0 and moves down.

    Parameters
    ----------
    path : Path
        The film, for example void_ratio.mp4; it bears this name only once closed.
    width_m, height_m : float
        Inner width of the silo and height of the sand, m.
    displacement_m : float
        Final downward displacement of the bottom plate, m.
    spacing_m : float
        Nominal spacing of the material points, m.
    weight_N_per_m : float
        Weight of the sand per metre of depth, N/m; the force axis ends at 1.1 times this.
    void_ratio_range : tuple of float
        Void ratios at the two ends of the colours.
    title : str
        One line above the picture.
    frames_per_second : int
        Frame rate.
    course : Course
        What the curves are drawn against; the displacement if absent.
    solids : list of ndarray
        Outlines (n, 2) of what stands still, a floor among them, m; None: a bottom plate sinks.

    Raises
    ------
    ValueError
        If a length, the weight or the frame rate is not positive, or the void ratios do not increase.
    """

    def __init__(
        self,
        path: Path,
        *,
        width_m: float,
        height_m: float,
        displacement_m: float,
        spacing_m: float,
        weight_N_per_m: float,
        void_ratio_range: tuple[float, float],
        title: str,
        frames_per_second: int = 30,
        course: Course | None = None,
        solids: list | None = None,
    ):
        if not min(width_m, height_m, displacement_m, spacing_m, weight_N_per_m, frames_per_second) > 0:
            raise ValueError("width, height, displacement, spacing, weight and frame rate must be positive")
        if not void_ratio_range[0] < void_ratio_range[1]:
            raise ValueError(f"void_ratio_range must increase, got {void_ratio_range}")
        self.void_ratio_range = void_ratio_range
        self.sinks = solids is None
        self.canvas = Canvas(
            width_m, height_m, displacement_m, weight_N_per_m, void_ratio_range, title, course,
            None if self.sinks else 0.0,
        )  # fmt: skip
        panel = self.canvas.panel
        self.raster = SandRaster(
            panel.columns, panel.rows, self.canvas.pixels_per_metre, self.canvas.top_m, spacing_m, solids or ()
        )
        self.segments = Segments(Path(path), lambda piece: Encoder(piece, frames_per_second))

    def add_forces(
        self, displacement_m: float, bottom_N_per_m: float, shear_N_per_m: float, normal_N_per_m: float
    ) -> None:
        """Extend the force curves by one row: forces in N/m (walls: mean of both), displacement in m (or course).

        At 0 (filling) the points only move along u = 0; rows that are not finite are left out.
        """
        self.canvas.add_forces(displacement_m, np.array([bottom_N_per_m, shear_N_per_m, normal_N_per_m]))

    def add_frame(
        self,
        position: np.ndarray,
        void_ratio: np.ndarray,
        *,
        time_s: float,
        stage: str,
        displacement_m: float,
    ) -> None:
        """Draw and encode one frame.

        Parameters
        ----------
        position : ndarray, shape (n, 2)
            Material points in the lab frame, m; points that are not finite are left out.
        void_ratio : ndarray, shape (n,)
            Their void ratios; values beyond the range take the colour of its end.
        time_s : float
            Time shown, s.
        stage : str
            "filling" or "flow".
        displacement_m : float
            Downward displacement of the bottom plate, m; with a course of its own, the place on that.

        Raises
        ------
        ValueError
            If the shapes do not fit.
        RuntimeError
            If the film is closed or ffmpeg has stopped.
        """
        position, void_ratio = np.asarray(position, np.float64), np.asarray(void_ratio, np.float64)
        if position.ndim != 2 or position.shape[1] != 2 or void_ratio.shape != position.shape[:1]:
            raise ValueError(f"want (n, 2) and (n,), got {position.shape} and {void_ratio.shape}")
        finite = np.isfinite(position).all(axis=1) & np.isfinite(void_ratio)
        low, high = self.void_ratio_range
        level = np.rint((COLOURS - 1) * np.clip((void_ratio[finite] - low) / (high - low), 0.0, 1.0))
        plate_top = -displacement_m if self.sinks else -10.0 * self.canvas.top_m
        sand = self.raster.draw(position[finite], level, plate_top, plate_top - self.canvas.plate_m)
        frame = self.canvas.page(time_s, stage, displacement_m)
        frame[self.canvas.panel.slices] = sand
        self.segments.write(frame)

    def close(self) -> None:
        """Finish the film and give it its name; safe to call again, and after an aborted run."""
        self.segments.close()

    def __enter__(self) -> "Film":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
