"""How a run is drawn: field, colours, page and part of the silo; and what of the silo is then seen."""

import math
from dataclasses import dataclass, replace

from taichi_silo.errors import BadInput
from taichi_silo.runs.point_fields import Scale
from taichi_silo.scene.scene import Scene
from taichi_silo.show.film.layout import SAND, SIZE, SIZES, Layout, View, alone, layout

# of matplotlib; the lightness of the first six rises from end to end, that of the others rises up to the middle and
# falls again, with ends that colour-blind viewers tell apart
COLOURS = ("viridis", "cividis", "plasma", "inferno", "magma", "gray", "coolwarm", "PuOr", "BrBG")
PLATE_SHARE, PLATE_AT_MOST = 0.02, 0.1  # thickness of the bottom: of the longer side, and at most of the height
AIR = 0.015  # of the height, above the fill


@dataclass(frozen=True)
class Look:
    """How a field is drawn.

    Attributes
    ----------
    field : its name.
    limits : values at the ends of the colours; from the scene and the data if absent.
    size : columns and rows; that of the layout if absent.
    layout : "16:9", "9:16", "1:1" or "sand"; the nearest to the size if absent.
    axes : whether the sand has axes.
    colours : one of `COLOURS`; those of the field if absent.
    zoom_mm : left, bottom, right and top of what is seen; the whole silo if absent.
    title : above everything; sand, walls and silo if absent.
    transparent : whether what is no sand and no ink is see-through.

    """

    field: str = "void_ratio"
    limits: tuple[float, float] | None = None
    size: tuple[int, int] | None = None
    layout: str | None = None
    axes: bool = True
    colours: str | None = None
    zoom_mm: tuple[float, float, float, float] | None = None
    title: str | None = None
    transparent: bool = False

    def coloured(self, scale: Scale) -> Scale:
        """A scale with the colours that were asked for."""
        return scale if self.colours is None else replace(scale, colours=self.colours)

    @property
    def page_size(self) -> tuple[int, int]:
        """Columns and rows, where the sand does not say them."""
        return self.size or SIZES.get(self.layout or "", SIZE)

    def page(self, view: View, at_most: float = math.inf, size: tuple[int, int] | None = None) -> Layout:
        """The page for a view, of so many pixels per metre at most; of another size than the look's if one is given."""
        if self.layout == SAND:
            return alone(size or self.size, view, at_most)
        return layout(size or self.page_size, view, self.axes, at_most)


def whole(scene: Scene) -> View:
    """All of a silo: wall to wall, from below the bottom when it has sunk to a little above the fill."""
    silo = scene.silo
    sinks_m = scene.flow.displacement_m if silo.floor_is_outlet else 0.0
    return View(0.0, -(sinks_m + plate_m(scene)), silo.width_m, (1.0 + AIR) * silo.height_m)


def plate_m(scene: Scene) -> float:
    """Thickness with which the bottom is drawn [m]."""
    wide, high = scene.silo.width_m, scene.silo.height_m
    return min(PLATE_SHARE * max(high, wide), PLATE_AT_MOST * high)


def view_of(scene: Scene, look: Look) -> View:
    """What is seen of a silo.

    Raises
    ------
    BadInput
        if the box of the look is no box in it, or smaller than two points of the sand.

    """
    all_of_it = whole(scene)
    if look.zoom_mm is None:
        return all_of_it
    view = View(*(1e-3 * float(value) for value in look.zoom_mm))
    inside = all(math.isfinite(value) for value in view)
    inside = inside and all_of_it.left - 1e-9 <= view.left and view.right <= all_of_it.right + 1e-9
    inside = inside and all_of_it.bottom - 1e-9 <= view.bottom and view.top <= all_of_it.top + 1e-9
    least = 2.0 * scene.spacing_m
    if not (inside and view.right - view.left >= least and view.top - view.bottom >= least):
        box, ends = (",".join(f"{value:g}" for value in values) for values in (look.zoom_mm, _millimetres(all_of_it)))
        raise BadInput(
            f"zoom is {box}; it must be LEFT,BOTTOM,RIGHT,TOP in mm, within {ends} and at least {1e3 * least:g} mm "
            "wide and high"
        )
    return view


def _millimetres(view: View) -> list[float]:
    """The view rounded inwards to 0.1 mm."""
    ends = [1e4 * value for value in view]
    return [0.1 * value for value in (math.ceil(ends[0] - 1e-6), math.ceil(ends[1] - 1e-6),
            math.floor(ends[2] + 1e-6), math.floor(ends[3] + 1e-6))]  # fmt: skip
