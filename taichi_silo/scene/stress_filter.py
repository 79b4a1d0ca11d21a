"""Which filter of the stresses a scene needs."""

from typing import TYPE_CHECKING

from taichi_silo.mpm.patch_filter import STRAIN

if TYPE_CHECKING:
    from taichi_silo.scene.scene import Scene


def filter_of(scene: "Scene") -> tuple[str, str]:
    """Name of the filter, of `mpm.filters.FILTERS`, and why in a sentence."""
    asked, count, silo = scene.method.stress_filter, scene.grid.points_per_cell, scene.silo
    if asked not in ("auto", "patch"):
        return asked, f"As asked for: {asked}."
    if asked == "auto" and count == 1 and silo.cuts_cells:
        return "none", (
            "Beside walls that cut cells nodes may need stresses that vary from cell to cell; with one point a cell "
            "the patch filter would take them and make the sand creep. With four points it stays."
        )
    return "patch", (
        f"With {count} point{'s' * (count > 1)} a cell nodes do not feel {3 * count - 2} of {3 * count} patterns of "
        f"stress, and sheared sand holds none of them; those that vary from point to point fade over {STRAIN:g} of "
        "strain."
        + " Beside walls that cut cells that would make sand creep: it waits for flow, and what nodes feel stays."
        * silo.cuts_cells
    )
