"""What a simulation needs to go on from a record as if it had never been left: `of` takes it, `restore` puts it back.

Beside what the scene says this is: the clocks, how far the filling is, the points and their names, what has left, the
last survey, and of the solver what outlives an interval: the nodes' last velocities and memory, the tractions of
surfaces, the order of the points in lanes, and of a non-local average the state that its rows were built from, of
which they are built once more. All other fields are made anew in each step.
"""

import dataclasses
from types import SimpleNamespace

from taichi_silo.simulation import filling, outflow

CLOCK = (
    "time", "displacement", "stage", "settled", "finished", "flow_start", "bottom_speed", "left_at", "step", "steps",
    "stepping_seconds", "seen",
)  # fmt: skip
NODAL = {"memory": "memory", "velocity": "velocity", "change": "change", "echo": "second_velocity"}  # key: field


def of(simulation) -> dict:
    """Numbers, words, arrays, and dictionaries of them."""
    particles, solver, ledger = simulation.particles, simulation.solver, simulation.ledger
    kept = {
        "clock": {name: getattr(simulation, name) for name in CLOCK} | {"loads": particles.revision},
        "filling": dataclasses.asdict(simulation.filling),
        "warnings": list(simulation.warnings),
        "alarms": simulation.alarms.state(),
        "after": vars(simulation.after) if simulation.after else None,
        "points": particles.arrays() | {"identity": simulation.identity},
        "nodes": {key: getattr(simulation.grid, name).to_numpy() for key, name in NODAL.items()},
    }
    if ledger:
        kept["ledger"] = {"mass": ledger.mass, "momentum": ledger.momentum, "points": ledger.points}
    if solver.surfaces.ACTIVE:
        kept["surfaces"] = {name: getattr(solver.surfaces, name).to_numpy() for name in ("traction", "seen")}
    if (state := solver.executor.state()) is not None:
        kept["lanes"] = state
    if solver.averaging.ACTIVE and solver.averaging.rows.revision == particles.revision:
        kept["rows"] = solver.averaging.rows.origin | {"builds": solver.averaging.rows.builds}
    return kept


def restore(simulation, kept: dict) -> None:
    """Put it back into a simulation of the same scene that has not been begun."""
    particles, points, clock = simulation.particles, dict(kept["points"]), dict(kept["clock"])
    loads = clock.pop("loads")
    for name in CLOCK:
        setattr(simulation, name, clock[name])
    simulation.filling = filling.Progress(**kept["filling"])
    simulation.warnings = list(dict.fromkeys([*kept["warnings"], *simulation.warnings]))
    simulation.alarms.restore(kept["alarms"])
    simulation.after = SimpleNamespace(**kept["after"]) if kept["after"] else None
    simulation.identity = points.pop("identity")
    if simulation.stage == "flow" and simulation.scene.flow.outflow == "gravity":
        outflow.loosen(simulation)
    solver = simulation.solver
    if "rows" in kept:
        rows = dict(kept["rows"])
        builds = rows.pop("builds")
        particles.load(points | rows)
        solver.averaging.rows.build()
        solver.averaging.rows.builds, solver.averaging.rows.revision = builds, loads
    particles.load(points)
    particles.revision = loads
    for key, values in kept["nodes"].items():
        getattr(simulation.grid, NODAL[key]).from_numpy(values)
    if simulation.ledger:
        for name, value in kept["ledger"].items():
            setattr(simulation.ledger, name, value)
    for name, values in kept.get("surfaces", {}).items():
        getattr(solver.surfaces, name).from_numpy(values)
    solver.executor.restore(kept.get("lanes"))
