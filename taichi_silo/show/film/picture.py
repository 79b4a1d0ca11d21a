"""One frame: the sand coloured by a field, beside the force curves up to then."""

import numpy as np

from taichi_silo.runs.point_fields import Scale
from taichi_silo.show.film.canvas import SIZE, Canvas, Course
from taichi_silo.show.film.point_raster import SandRaster, levels


class Picture:
    """Draws frames of one silo; ti.init must have been called.

    The silo stands between x = 0 and x = `width_m`; its bottom plate starts at y = 0 and moves down.

    Parameters
    ----------
    width_m, height_m : float
        Inner width of the silo and height of the sand, m.
    displacement_m : float
        Final downward displacement of the bottom plate, m.
    spacing_m : float
        Nominal spacing of the material points, m.
    weight_N_per_m : float
        Weight of the sand per metre of depth, N/m; the force axis ends at 1.1 times this.
    scale : Scale
        Of the field.
    title : str
        One line above the picture.
    course : Course
        What the curves are drawn against; the displacement if absent.
    solids : list of ndarray
        Outlines (n, 2) of what stands still, a floor among them, m; None: a bottom plate sinks.
    size : tuple of int
        Columns and rows of a frame.

    Raises
    ------
    ValueError
        If a length or the weight is not positive, or the ends of the scale do not increase.
    """

    def __init__(
        self,
        *,
        width_m: float,
        height_m: float,
        displacement_m: float,
        spacing_m: float,
        weight_N_per_m: float,
        scale: Scale,
        title: str,
        course: Course | None = None,
        solids: list | None = None,
        size: tuple[int, int] = SIZE,
    ):
        if not min(width_m, height_m, displacement_m, spacing_m, weight_N_per_m) > 0:
            raise ValueError("width, height, displacement, spacing and weight must be positive")
        if not scale.low < scale.high:
            raise ValueError(f"range of {scale.label} must increase, got {scale.low}, {scale.high}")
        self.scale = scale
        self.sinks = solids is None
        self.canvas = Canvas(
            width_m, height_m, displacement_m, weight_N_per_m, scale, title, course, None if self.sinks else 0.0, size
        )
        panel = self.canvas.panel
        self.raster = SandRaster(
            panel.columns, panel.rows, self.canvas.pixels_per_metre, self.canvas.top_m, spacing_m, scale.colours,
            solids or (),
        )  # fmt: skip

    def add_forces(
        self, displacement_m: float, bottom_N_per_m: float, shear_N_per_m: float, normal_N_per_m: float
    ) -> None:
        """Extend the force curves by one row: forces in N/m (walls: mean of both), displacement in m (or course).

        At 0 (filling) the points only move along u = 0; rows that are not finite are left out.
        """
        self.canvas.add_forces(displacement_m, np.array([bottom_N_per_m, shear_N_per_m, normal_N_per_m]))

    def frame(
        self,
        position: np.ndarray,
        values: np.ndarray,
        *,
        time_s: float,
        stage: str,
        displacement_m: float,
    ) -> np.ndarray:
        """Draw one frame, (rows, columns, 3) of bytes.

        Parameters
        ----------
        position : ndarray, shape (n, 2)
            Material points in the lab frame, m; points that are not finite are left out.
        values : ndarray, shape (n,)
            Of the field; those beyond the range take the colour of its end, those that are not finite are grey.
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
        """
        position, values = np.asarray(position, np.float64), np.asarray(values, np.float64)
        if position.ndim != 2 or position.shape[1] != 2 or values.shape != position.shape[:1]:
            raise ValueError(f"want (n, 2) and (n,), got {position.shape} and {values.shape}")
        finite = np.isfinite(position).all(axis=1)
        level = levels(self.scale.share(values[finite]))
        plate_top = -displacement_m if self.sinks else -10.0 * self.canvas.top_m
        sand = self.raster.draw(position[finite], level, plate_top, plate_top - self.canvas.plate_m)
        frame = self.canvas.page(time_s, stage, displacement_m)
        frame[self.canvas.panel.slices] = sand
        return frame
