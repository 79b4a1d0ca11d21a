"""The state of a solver between two intervals: what outlives an interval beside the points.

That is the nodes' last velocities and their memory, the tractions of surfaces, the order of the points on the vector
unit, what a filter has seen of the strain, and of a non-local average the state that its rows were built from, of which
they are built once more. All other fields are made anew in each step.
"""

import numpy as np

from taichi_silo.mpm.field_memory import present, put
from taichi_silo.mpm.solver import Solver

NODAL = {"memory": "memory", "velocity": "velocity", "change": "change", "echo": "second_velocity"}  # key: field


def state_of(solver: Solver) -> dict:
    """Arrays (the fields themselves, if possible), numbers, and dictionaries of them."""
    fields = {key: getattr(solver.grid, name) for key, name in NODAL.items()}
    kept: dict = {"nodes": {key: present(field) for key, field in fields.items() if field is not None}}
    if solver.surfaces.ACTIVE:
        kept["surfaces"] = {name: present(getattr(solver.surfaces, name)) for name in ("traction", "seen")}
    if (order := solver.executor.state()) is not None:
        kept["lanes"] = order
    if solver.filter.BETWEEN_LAUNCHES and solver.filter.revision == solver.particles.revision:
        kept["filter"] = solver.filter.state()
    if solver.averaging.ACTIVE and solver.averaging.means.revision == solver.particles.revision:
        kept["rows"] = solver.averaging.means.origin | {"builds": solver.averaging.means.builds}
    return kept


def restore(solver: Solver, kept: dict, points: dict[str, np.ndarray], revision: int) -> None:
    """Load points, which get this number of revision, and what `state_of` took when they were there."""
    if solver.averaging.ACTIVE:
        solver.averaging.means.forget()
        if "rows" in kept:
            origin = {name: kept["rows"][name] for name in ("position", "volume")}
            solver.particles.load(points | origin, revision)
            solver.averaging.means.build()
    solver.particles.load(points, revision)
    for key, array in kept["nodes"].items():
        if (field := getattr(solver.grid, NODAL[key])) is not None:
            old = key == "memory" and array.shape == field.shape[::-1]  # of a version that kept it by nodes
            put(field, array.T if old else array)
    if "surfaces" in kept:
        solver.surfaces.restore(**kept["surfaces"])
    if solver.filter.BETWEEN_LAUNCHES:
        solver.filter.restore(kept.get("filter"))
    solver.executor.restore(kept.get("lanes"))
    solver.impulses.read_and_reset()
