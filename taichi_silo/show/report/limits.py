"""What is known not to converge, or not to be told, in a run of this kind: the README's known limits that apply."""

from taichi_silo.runs.result import Result
from taichi_silo.scene.fidelity import like
from taichi_silo.show.titles import loose

FEWEST_CELLS = 10  # that an outlet should be wide
SLENDER = 6.25  # height over width from which sand still ratchets on fine cells
SLOW = 0.002  # m/s in the silo of 0.5 m: below, N has no trend any more


def known_limits(run: Result) -> list[str]:
    """A sentence for each, the weightiest first."""
    found, scene = [], run.scene
    silo, cell, speed = scene.silo, scene.grid.cell_size_m, scene.flow.speed_m_per_s
    rough = scene.walls.kind == "very-rough"
    local = any(
        one.get("part") == "non-local average" and one.get("choice") == "off" for one in run.summary.get("parts") or []
    )
    if rough:
        found.append(
            "Wall normal forces N and wall normal stresses between very rough walls are not converged: of dense sand "
            "in a silo of 0.2 m × 0.5 m N gains 11 % from 10 to 5 mm cells and, with a local law, as much again to "
            "2.5 mm; T changes by 1 to 4 %."
        )
        found.append(
            "The largest wall stresses between very rough walls, and which wall has them beside an eccentric outlet, "
            "depend on the floor's friction, too."
        )
    named = like(cell, speed) if rough and not run.free else None
    if named and named[1].error_N is not None:
        found.append(
            f"Cells and speed are those of the fidelity {named[0]}. In the silo of 0.2 m × 0.5 m with dense sand it "
            f"errs by {named[1].error_P:.0%} in P, {named[1].error_T:.1%} in T, {named[1].error_N:.1%} in N and "
            f"{named[1].error_profile:.0%} in the wall stresses, against {named[1].reference}."
        )
    if local:
        found.append(
            f"The law has no length of its own on this grid: shear zones are one to two cells ({1e3 * cell:g} to "
            f"{2e3 * cell:g} mm) thick, and what depends on their thickness depends on the grid."
        )
    if rough and loose(scene.sand):
        found.append(
            "Loose sand between very rough walls splits into bands one cell high while it is filled in; P, T and N "
            "scatter by 2 to 4 % between runs that differ in nothing but rounding."
        )
    if not silo.floor_is_outlet:
        found += _of_outlet(run)
    if rough and not run.free and speed > SLOW * 1.001:
        found.append(
            f"The outflow is driven at {1e3 * speed:g} mm/s. Between very rough walls N falls with the speed: at "
            f"20 mm/s it is some 11 to 14 % below that at {1e3 * SLOW:g} mm/s, from where on it keeps its value."
        )
    if silo.height_m > SLENDER * silo.width_m:
        found.append(
            "Slender silos with fine cells still ratchet in flow: look at the unexplained densification of the "
            "certificate."
        )
    if scene.filling.kind in ("layers", "rain"):
        found.append(
            "Sand filled in by layers or rain pressed on smooth walls by 29 to 36 % more than sand whose weight grows: "
            "noise of the filling that flow does not take back."
        )
    return found


def _of_outlet(run: Result) -> list[str]:
    left, right = run.scene.silo.outlet_m
    found, cells = [], (right - left) / run.scene.grid.cell_size_m
    if cells < FEWEST_CELLS - 1e-6:
        found.append(
            f"The outlet is {cells:.3g} cells wide, and half a cell of sand is held beside each of its "
            f"edges: it should be {FEWEST_CELLS} cells or more."
        )
    if run.scene.grid.points_per_cell == 1:
        found.append(
            "Sand that flows across a grid that stands still, with one point a cell, carries stripes of two cells in "
            "void ratio and stress."
        )
    if run.scene.silo.hopper is not None or run.scene.silo.inserts:
        found.append("On inclined walls single rows of the grid mean little; means over 50 mm do.")
    if run.free:
        found.append("The noise control slows true transients that are shorter than some 40 ms (in the silo of 0.5 m).")
    return found
