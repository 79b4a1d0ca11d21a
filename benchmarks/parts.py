"""What each part of the method costs, and what it changes in P, T and N: `make parts`.

A standard silo (dense sand, smooth and very rough walls, one point a cell, local law, whole) is run as it is and with
one part put in or left out. Time is that of a second of flow, both in turns on the flowing sand, so that a smaller time
step counts; forces are means over the last fifth of the displacement. Prints a table in Markdown and writes
outputs/bench/parts.csv. Cost: some minutes on one core.
"""

import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, NamedTuple
from unittest.mock import patch

import pandas as pd
from typer import Option

from taichi_silo.cli import command_line, model_silo
from taichi_silo.mpm import runtime
from taichi_silo.mpm.laws import integrate
from taichi_silo.runs.observers.film_recorder import FilmRecorder
from taichi_silo.scene import averaging
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Method, Sand, Scene, Silo, Walls
from taichi_silo.simulation.simulation import STEP_SAFETY, Simulation

ROUNDS = 7
SECONDS = 0.2  # of one measurement
FORCES = ("bottom", "shear", "normal")
COLUMNS = ("walls", "part", "tried", "time_percent", *(f"{force}_percent" for force in FORCES))
NEVER = 1e30  # an error that no step has


class Trial(NamedTuple):
    """One part of the method, put in or left out."""

    part: str
    tried: str
    tables: Callable[[Scene], dict]  # of the scene, changed
    otherwise: Callable = nullcontext  # a context in which its kernels are compiled
    walls: tuple[str, ...] = ("smooth", "very-rough")


def trials(cell_m: float) -> list[Trial]:
    """All trials for a cell size."""
    return [
        Trial("half model", "put in", lambda s: {"silo": Silo(half="yes")}),
        Trial(
            "non-local average", f"put in, l_c = {2e3 * cell_m:g} mm",
            lambda s: {"averaging": Averaging(characteristic_length_m=2.0 * cell_m)},
        ),
        Trial(
            "non-local average", "put in where a point's own weight is 1.0000",
            lambda s: {"averaging": Averaging(characteristic_length_m=0.3 * cell_m)},
            lambda: patch.object(averaging, "INACTIVE_FROM", 2.0),
        ),
        Trial("intergranular strain", "put in", lambda s: {"sand": Sand(law="intergranular")}),
        Trial(
            "stress sub-stepping", "left out", lambda s: {}, lambda: patch.object(integrate, "LOCAL_ERROR", NEVER)
        ),
        Trial("particle domains", "put in (cpgimp)", lambda s: {"grid": Mesh(cell_size_m=cell_m, shape="cpgimp")}),
        Trial(
            "wall friction solve", "left out (0°)", lambda s: {"walls": Walls(kind="smooth", friction_angle_deg=0.0)},
            walls=("smooth",),
        ),
        Trial(
            "noise control", "left out",
            lambda s: {"method": s.method.model_copy(update={"noise_control": "none"})},
        ),
        Trial("points a cell", "4 instead of 1", lambda s: {"grid": Mesh(cell_size_m=cell_m, points_per_cell=4)}),
    ]  # fmt: skip


def standard(walls: str, cell_m: float, displacement_m: float) -> Scene:
    """The silo without any part that it can do without."""
    return Scene(
        silo=Silo(half="no"), walls=model_silo.walls(walls, 0.60), grid=Mesh(cell_size_m=cell_m),
        averaging=Averaging(characteristic_length_m=0.0), method=Method(noise_control="column"),
        flow=Flow(speed_m_per_s=0.005, displacement_m=displacement_m), machine=Machine(threads=1),
    )  # fmt: skip


class MeasuredRun:
    """A silo, filled and lowered, whose steps can then be timed.

    Attributes
    ----------
    forces : means of P, T, N over the last fifth of the displacement [N/m].
    film_s, records_s : seconds that the states of the film and the records took.

    """

    def __init__(self, what: Scene, film: Path | None = None):
        self.simulation = Simulation(what)
        watched = [FilmRecorder(film)] if film else []
        for observer in watched:
            observer.begin(self.simulation)
        begun, filming, rows = time.perf_counter(), 0.0, []
        for record in self.simulation.run():
            rows.append(record)
            started = time.perf_counter()
            for observer in watched:
                observer.observe(record)
            filming += time.perf_counter() - started
        whole = time.perf_counter() - begun
        started = time.perf_counter()
        for observer in watched:
            observer.end()
        self.film_s = filming + time.perf_counter() - started
        self.records_s = whole - filming - self.simulation.clock.stepping_seconds
        last = [r for r in rows if r.displacement_m > 0.8 * what.flow.displacement_m]
        span = sum(r.interval_s for r in last)
        self.forces = [sum(getattr(r, f"{name}_N_per_m") * r.interval_s for r in last) / span for name in FORCES]

    def seconds(self, least: float) -> float:
        """Time that a second of flow takes, measured over about so long."""
        solver, gravity = self.simulation.solver, self.simulation.model.gravity
        speed = self.simulation.scene.flow.speed_m_per_s
        dt, steps, begun = STEP_SAFETY * solver.point_sums().stable_step, 0, time.perf_counter()
        while time.perf_counter() < begun + least:
            solver.advance(100, dt, (gravity, gravity), (-speed, -speed))
            runtime.wait()
            steps += 100
        return (time.perf_counter() - begun) / (steps * dt)


def slower(run: MeasuredRun, usual: MeasuredRun) -> float:
    """Time of a second of flow over the usual one, less 1: median over rounds, measured in turns."""
    return statistics.median(run.seconds(SECONDS) / usual.seconds(SECONDS) for _ in range(ROUNDS)) - 1.0


def row(walls: str, part: str, tried: str, change: float, forces=(0.0, 0.0, 0.0)) -> dict:
    """A row of the table; changes are given as shares and stand there in percent."""
    values = (100.0 * value for value in (change, *forces))
    return dict(zip(COLUMNS, (walls, part, tried, *values), strict=True))


def measure(walls: str, cell_m: float, displacement_m: float) -> list[dict]:
    """Measure all rows for one kind of walls."""
    runtime.init()
    base = standard(walls, cell_m, displacement_m)
    with tempfile.TemporaryDirectory() as folder:
        usual = MeasuredRun(base, Path(folder) / "film_states.bin")
    stepping = usual.simulation.clock.stepping_seconds
    film = f"states put in: {usual.film_s:.1f} s whatever the run, here of {stepping:.0f} s"
    rows = [
        row(walls, "film", film, usual.film_s / stepping),
        row(walls, "records", "put in, 10 a period", usual.records_s / stepping),
    ]
    for trial in trials(cell_m):
        if walls not in trial.walls:
            continue
        with trial.otherwise():
            run = MeasuredRun(base.model_copy(update=trial.tables(base)))
        changes = [own / other - 1.0 for own, other in zip(run.forces, usual.forces, strict=True)]
        rows.append(row(walls, trial.part, trial.tried, slower(run, usual), changes))
        print(".", end="", flush=True)
    return rows


def parts(
    cell_size: Annotated[float, Option(help="of the grid [m]")] = 0.01,
    displacement: Annotated[float, Option(help="of the bottom at the end [m]")] = 0.002,
):
    """Measure what every part costs and changes."""
    rows = [r for walls in ("smooth", "very-rough") for r in measure(walls, cell_size, displacement)]
    folder = Path("outputs") / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    pd.DataFrame(rows, columns=COLUMNS).to_csv(folder / "parts.csv", index=False)
    print(f"\n\n{markdown(rows)}\nwritten to {folder / 'parts.csv'}")


def markdown(rows: list[dict]) -> str:
    """The table, as the documentation shows it."""
    lines = ["| walls | part | | time | P | T | N |", "|---|---|---|---|---|---|---|"]
    for r in rows:
        values = [r["time_percent"], *(r[f"{force}_percent"] for force in FORCES)]
        words = [f"{values[0]:+.0f} %", *(f"{value:+.2f} %" if abs(value) >= 0.005 else "0" for value in values[1:])]
        lines.append("| " + " | ".join([r["walls"], r["part"], r["tried"], *words]) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    command_line.command(parts)
