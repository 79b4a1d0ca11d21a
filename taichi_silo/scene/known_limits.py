"""Known limits of what is computed: where a choice of method fails, and which results of a scene are not converged.

The first are said before a run starts and kept in its summary: each is a cell of the stability map
(`scenarios/stability.py`) that the choice can reach in a silo. The second stand in the report of a run.
"""

from collections.abc import Iterator

import numpy as np
import shapely

from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.scene.cell_sizes import WIDE_OUTLET, narrowest_m, widest_m
from taichi_silo.scene.fidelity import like, measured
from taichi_silo.scene.flow import slow_speed_m_per_s
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.silo import Silo
from taichi_silo.scene.symmetry import SLENDER
from taichi_silo.scene.touching import NEAR

NOISY = ("apic", "gradient", "xpic", "blend", "pic")
FEWEST_CELLS = 10  # that an outlet should be wide
THICK = 2  # cells that a body, or a gap beside one, should be: sand reaches a cell into a body from each side
BEGUN = 0.05  # of the outlet's width: until a gate has sunk as far, sand only loosens, and all of it a little
DEAD_EDGE, OF_MORE = 1.7, 0.2  # cells of its width that pass nothing in free outflow, of one and of four points each


def of_method(scene: Scene) -> list[str]:
    """One sentence for each choice that is known to fail somewhere."""
    method, found = scene.method, []
    if scene.grid.shape == "linear":
        found.append(
            "Linear shapes: stresses err by a fifth where points cross cells, nearly empty cells at a free surface "
            "make any step unstable, and sand that flows freely is lost; ugimp or cpdi cure it."
        )
    if scene.grid.shape == "bspline" and scene.grid.points_per_cell > 1:
        found.append(
            "Splines ignore that several points share a cell: stresses of a compressed column err by 5 % (ugimp 2 %, "
            "cpdi 0.3 %)."
        )
    if method.stress_filter == "smoothing":
        found.append(
            "The smoothing filter is no projection: a stress at rest is gone after 1,000 steps, and a silo falls apart "
            "under it; patch, the default, takes out what no node feels and leaves stresses alone."
        )
    if method.noise_control == "none":
        found.append(
            "Without noise control dense sand between smooth walls ratchets: N is a third too high after filling, and "
            f"{'PIC-like transfers leave 5 to 13 %' if method.transfer in NOISY[2:] else 'void ratio keeps falling'}."
        )
    if method.stress_update != "last":
        found.append(
            f"Updating the stress in the order {method.stress_update} damps nothing: N of dense sand between smooth "
            "walls is 12 % too high after filling in spite of the noise control."
        )
    shape = SHAPES[scene.grid.shape]
    fraction = shape(0.5 / scene.grid.points_per_cell**0.5).stable_fraction
    if method.cfl is not None and method.cfl > fraction:
        found.append(
            f"cfl is {method.cfl:g}; the shape's own limit is {fraction:.3f}, and beyond it results are wrong before "
            "anything explodes."
        )
    if method.mass_scaling > 1.0:
        found.append(
            f"Mass scaling by {method.mass_scaling:g} makes the sand feel a bottom {method.mass_scaling**0.5:.3g} "
            "times as fast: N and P between very rough walls change as with that speed."
        )
    one, cells = scene.grid.points_per_cell == 1, cells_across_outlet(scene)
    if scene.flow.outflow == "gravity" and cells < (enough := WIDE_OUTLET if one else FEWEST_CELLS) - 1e-6:
        share = max(0.0, 1.0 - (DEAD_EDGE if one else OF_MORE) / cells) ** 1.5
        size = f"a cell size of {1e3 * scene.grid.cell_size_m * cells / enough:.3g} mm"
        found.append(
            f"The outlet is {cells:.3g} cells wide: sand falls out at {share:.0%} of the rate that a fine grid gives"
            f"{', and may jam' if cells < FEWEST_CELLS - 1e-6 else ''}; {enough} cells or more would do, as with {size}"
            f"{', or four points a cell' if one else ''}."
        )
    h = scene.grid.cell_size_m
    for number, insert in enumerate(scene.silo.inserts):
        if shapely.Polygon(insert.outline(scene.silo.width_m)).buffer(-0.5 * THICK * h * (1.0 - 1e-6)).is_empty:
            found.append(
                f"Insert {number + 1}, a {insert.kind}, is less than {THICK} cells of {1e3 * h:g} mm thick: the sand "
                "on both of its sides shares nodes, and drags itself along through it."
            )
    found += _narrow_gaps(scene)
    if scene.flow.outflow == "controlled" and scene.silo.has_opening and cells < FEWEST_CELLS - 1e-6:
        fine_mm = 1e3 * scene.grid.cell_size_m * cells / FEWEST_CELLS
        found.append(
            f"The outlet is {cells:.3g} cells wide: less sand follows the gate than on a fine grid, or it jams; "
            f"{FEWEST_CELLS} cells or more would do, as with a cell size of {fine_mm:.3g} mm."
        )
    if scene.flow.outflow == "controlled" and not has_pattern(scene):
        found.append(
            f"The gate sinks by {1e3 * scene.flow.displacement_m:.3g} mm: until it has sunk by a twentieth of the "
            f"outlet's width ({1e3 * BEGUN * widest_m(scene.silo):.3g} mm) sand only loosens, and no flow pattern is "
            "told; a greater flow.displacement_m gives one."
        )
    return found


def _narrow_gaps(scene: Scene) -> Iterator[str]:
    """Gaps beside bodies through which the grid lets more or less sand pass than there is room for."""
    h = scene.grid.cell_size_m
    for gap, between in gaps(scene.silo):
        if gap < THICK * h * (1.0 - 1e-6):
            yield (
                f"Between {between} is a gap of {1e3 * gap:.3g} mm, less than {THICK} cells of {1e3 * h:g} mm: how "
                f"much sand passes there follows the grid; a cell size of {1e3 * gap / THICK:.3g} mm would do."
            )


def gaps(silo: Silo) -> Iterator[tuple[float, str]]:
    """Widths of the gaps beside bodies [m], and between what they are."""
    left, right = silo.sides
    others = {"the walls or the floor": shapely.LineString(np.concatenate([left[::-1], right]))}
    for number, insert in enumerate(silo.inserts, start=1):
        body = shapely.Polygon(insert.outline(silo.width_m))
        for name, other in others.items():
            gap = shapely.distance(body, other)
            if gap > NEAR:
                yield gap, f"insert {number} and {name}"
        others[f"insert {number}"] = body


def has_pattern(scene: Scene, displacement_m: float | None = None) -> bool:
    """Whether so much has left at a displacement, or the scene's own, that the flow has a pattern."""
    sunk = scene.flow.displacement_m if displacement_m is None else displacement_m
    return not scene.silo.has_opening or sunk >= BEGUN * widest_m(scene.silo) * (1.0 - 1e-9)


def cells_across_outlet(scene: Scene) -> float:
    """Width of the outlet, of several the narrowest, over that of a cell."""
    return narrowest_m(scene.silo) / scene.grid.cell_size_m


def of_results(scene: Scene) -> list[str]:
    """One sentence for each result of a scene that is known not to be converged, the weightiest first."""
    found, silo, cell, speed = [], scene.silo, scene.grid.cell_size_m, scene.flow.speed_m_per_s
    rough, free = scene.walls.kind == "very-rough", scene.flow.free
    if rough:
        if scene.characteristic_length_m > 3.0 * scene.sand.d50_m * (1.0 + 1e-9):
            found.append(
                f"The sand's own length of {3e3 * scene.sand.d50_m:.3g} mm is not resolved by the grid, and the law "
                f"takes {1e3 * scene.characteristic_length_m:.3g} mm: how thick zones are follows the grid."
            )
        elif cell > 1.5 * scene.characteristic_length_m:
            found.append(
                "Wall normal forces N and wall normal stresses between very rough walls are not converged: with a "
                "local law N of dense sand in a silo of 0.2 m × 0.5 m is a quarter too high on 5 mm cells."
            )
        found.append(
            "The largest wall stresses between very rough walls, and which wall has them beside an eccentric outlet, "
            "depend on the floor's friction, too."
        )
    named = like(scene)
    told = measured(scene, named) if named else None
    if told:
        found.append(f"Cells and speed are those of the fidelity {named}; {told.words()}.")
    if scene.averaging.kernel(scene.characteristic_length_m, scene.spacing_m)[0] is None:
        found.append(
            f"The law has no length of its own on this grid: shear zones are one to two cells ({1e3 * cell:g} to "
            f"{2e3 * cell:g} mm) thick, and what depends on their thickness depends on the grid."
        )
    if rough and scene.sand.loose:
        found.append(
            "Loose sand between very rough walls splits into bands one cell high while it is filled in; P, T and N "
            "scatter by 2 to 4 % between runs that differ in nothing but rounding."
        )
    if scene.grid.points_per_cell == 1 and silo.cuts_cells:
        found.append(
            "With one point a cell inclined walls hold a wrong share of the sand: after filling the outlet of a hopper "
            "of 20° bears 0.15 instead of 0.26 of the weight, of 45° 0.40 instead of 0.22; four points a cell cure it."
        )
    if silo.has_opening:
        found += _of_outlet(scene)
    slow = slow_speed_m_per_s(silo.width_m, scene.method.gravity_m_per_s2)
    if rough and not free and speed > slow * 1.001:
        found.append(
            f"The outflow is driven at {1e3 * speed:g} mm/s. Between very rough walls P falls with the speed: at "
            f"{8e3 * slow:g} mm/s by some 2 % of the weight against {1e3 * slow:g} mm/s, N and T change by less."
        )
    if scene.sand.layers:
        found.append(
            "Janssen's theory and EN 1991-4 take one sand: of layers they are given the mean bulk density, and the "
            "pressure ratio of the lowest layer."
        )
    if silo.height_m > SLENDER * silo.width_m:
        found.append(
            "Slender silos with fine cells still ratchet in flow: look at the unexplained densification of the "
            "certificate."
        )
    if scene.filling.kind in ("layers", "rain"):
        found.append(
            "Sand filled in by layers or rain pressed on smooth walls by a quarter to a third more than sand whose "
            "weight grows: noise of the filling that flow does not take back."
        )
    return found


def _of_outlet(scene: Scene) -> list[str]:
    found = []
    if scene.grid.points_per_cell == 1:
        found.append(
            "Sand that flows across a grid that stands still, with one point a cell, carries stripes of two cells in "
            "void ratio and stress."
        )
    if (
        scene.silo.hopper is not None
        and not scene.sand.loose
        and scene.characteristic_length_m < scene.grid.cell_size_m
    ):
        found.append(
            "Dense sand leaves a steep hopper in bands from wall to wall that set out from one wall at a time, which "
            "is chance: N of left and right wall may differ threefold, and their mean by a seventh from grid to grid. "
            f"With a characteristic length of a cell ({1e3 * scene.grid.cell_size_m:g} mm) there are no bands."
        )
    if scene.silo.hopper is not None or scene.silo.inserts:
        found.append("On inclined walls single rows of the grid mean little; means over a quarter of the width do.")
    return found
