"""A run's folder, read: tables as frames, states of the sand as arrays, the film."""

import base64
import os
from collections.abc import Callable
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.errors import BadInput
from taichi_silo.runs import snapshot
from taichi_silo.runs.inclined_walls import shown_forces
from taichi_silo.runs.observers.outflow import columns_of
from taichi_silo.runs.run_folder import CHECKPOINT, MADE, go_on
from taichi_silo.scene import bands
from taichi_silo.scene.outlets import mirrored
from taichi_silo.scene.scene import Scene, cores
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import shown

FILM = "void_ratio.mp4"
COLLAPSE = "collapse.csv"  # of a column
FORCES = (
    "time_s", "stage", "displacement_m", "bottom_force_N_per_m", "left_normal_N_per_m", "left_shear_N_per_m",
    "right_normal_N_per_m", "right_shear_N_per_m", "wall_friction_angle_deg", "weight_N_per_m",
)  # fmt: skip
OUTFLOW = ("time_s", "stage", "displacement_m")
BALANCE = ("time_s", "stage", "residual_N_per_m")
WALLS = ("state", "wall", "height_m", "normal_stress_Pa", "shear_stress_Pa")
SNAPSHOTS = ("file", "stage", "time_s", "displacement_m")
WORDS = ("stage", "state", "wall", "file")  # columns that hold no numbers
LARGEST = 1e12  # a run that went wrong may leave any number; none that means something is larger
RESIDUAL_SHARE = 0.05  # of the displacement: the last part of the flow, whose mean is the residual state


def at_rest(filling: pd.DataFrame, records_per_period: int) -> pd.DataFrame:
    """Records whose mean is the state after filling: those of the last natural period of the column before the flow.

    The column of sand swings on at its own period (some 20 ms) while it comes to rest; a mean over one whole period
    cancels that, which a mean or a median over any other span does not.

    Parameters
    ----------
    filling : records of the filling stage.
    records_per_period : of the scene's output.

    """
    return filling.tail(records_per_period)


def residual(flow: pd.DataFrame) -> pd.DataFrame:
    """Records whose mean is the residual state: those of the last 5 % of the displacement."""
    return flow[flow["displacement_m"] >= flow["displacement_m"].max() * (1.0 - RESIDUAL_SHARE)]


class Result(os.PathLike):
    """A run's folder, whose files are read when they are asked for; it stands for its path wherever one is wanted.

    The run may have ended, have failed, or go on: a file that is not there yet reads as empty, a table as far as it
    is written.

    Parameters
    ----------
    folder : of a run.
    label : name of the run in legends; that of the folder if not given.
    tolerant : read a damaged table or summary as empty, and name it in `trouble`, instead of raising BadInput.

    Raises
    ------
    BadInput
        if the folder holds no run; and later, if a file that is asked for is damaged.

    """

    def __init__(self, folder: str | os.PathLike, label: str = "", tolerant: bool = False):
        self.folder = bounded_reading.place(folder, "folder")
        if not (self.folder / MADE).is_file():
            why = f"it holds no {MADE}" if self.folder.is_dir() else "there is no such folder"
            raise BadInput(f"folder is {self.folder}; it must be that of a run, and {why}")
        self.label, self.tolerant = label or self.folder.resolve().name, tolerant
        self._damaged: list[str] = []

    def __fspath__(self) -> str:
        return str(self.folder)

    def __truediv__(self, name: str) -> Path:
        return self.folder / name

    def __repr__(self) -> str:
        state = "finished" if self.finished else "not finished"
        return f"Result({str(self.folder)!r}: {state})"

    # what was run

    @cached_property
    def parameters(self) -> dict:
        """The tables of `run.toml`."""
        return bounded_reading.toml(self.folder / MADE, "a run")

    @cached_property
    def scene(self) -> Scene:
        """What was run; on no more threads than this machine has cores."""
        if not isinstance(self.parameters.get("silo"), dict):
            raise BadInput(f"folder is {self.folder}; it must be that of a run of a silo, and its {MADE} names no silo")
        machine = self.parameters.get("machine")
        threads = machine.get("threads") if isinstance(machine, dict) else None
        return read_scene(self.folder / MADE, threads=min(threads, cores()) if isinstance(threads, int) else None)

    @property
    def program(self) -> dict:
        """Versions and time: what computed it."""
        found = self.parameters.get("program")
        return found if isinstance(found, dict) else {}

    @property
    def free(self) -> bool:
        """Whether the sand moves by its weight alone."""
        return self.scene.flow.free

    @property
    def lopsided(self) -> bool:
        """Whether left and right wall are not alike."""
        silo = self.scene.silo
        return not (mirrored(silo.openings, silo.width_m) and bands.alike(self.scene.walls))

    # what came out

    @cached_property
    def summary(self) -> dict:
        """Peaks, residuals, certificate, measures (`summary.json`); empty if the run has not ended."""
        return self._read("summary.json", bounded_reading.tables, {})

    @property
    def finished(self) -> bool:
        """Whether the run came to its end."""
        return bool(self.summary.get("finished", False))

    @cached_property
    def forces(self) -> pd.DataFrame:
        """`forces.csv`: a row an interval; normals positive in compression, shears where the wall carries weight.

        Besides the columns of the file it has `P`, `T` and `N` [N/m]: the force on the bottom, and friction and normal
        force of a wall as means of both; where none is vertical, of the inclined ones.
        """
        table = self._table("forces.csv", FORCES)
        walls = {
            name: (f"left_{part}_N_per_m", f"right_{part}_N_per_m") for name, part in (("T", "shear"), ("N", "normal"))
        }
        means = {name: 0.5 * (table[left] + table[right]) for name, (left, right) in walls.items()}
        table = table.assign(P=table["bottom_force_N_per_m"], **means)
        return table.assign(**shown_forces(self.scene.silo, table))

    @cached_property
    def filling(self) -> pd.DataFrame:
        """The rows of filling."""
        return self.forces[self.forces.stage == "filling"].reset_index(drop=True)

    @cached_property
    def flow(self) -> pd.DataFrame:
        """The rows of flow."""
        return self.forces[self.forces.stage == "flow"].reset_index(drop=True)

    @cached_property
    def filled(self) -> pd.Series | None:
        """The state after filling, as `at_rest` says: mean of each column of `forces`; None if there is none."""
        rows = at_rest(self.filling, self.scene.output.records_per_period)
        return None if rows.empty else rows.mean(numeric_only=True)

    @cached_property
    def residual(self) -> pd.Series | None:
        """The residual state, as `residual` says: mean of each column of `forces`; None without flow."""
        rows = residual(self.flow)
        return None if rows.empty else rows.mean(numeric_only=True)

    @cached_property
    def balance(self) -> pd.DataFrame:
        """`balance.csv`: how far forces, weight and momentum balance."""
        return self._table("balance.csv", BALANCE)

    @cached_property
    def outflow(self) -> pd.DataFrame:
        """`outflow.csv`: what has left by each of several outlets, how fast, and the force on its gate."""
        silo = self.scene.silo
        outlets = () if silo.one_opening else range(1, len(silo.outlets) + 1)
        return self._table("outflow.csv", (*OUTFLOW, *(name for number in outlets for name in columns_of(number))))

    @cached_property
    def walls(self) -> pd.DataFrame:
        """`walls.csv`: wall stresses after filling, at the largest N, and at the end."""
        return self._table("walls.csv", WALLS)

    def profile(self, state: str, wall: str, stress: str = "normal_stress_Pa") -> tuple[np.ndarray, np.ndarray]:
        """Rising heights above the initial bottom [m] and nodal stresses [Pa] along a wall; empty if there are none.

        Parameters
        ----------
        state : "filling", "maximum" or "residual".
        wall : "left", "right", "hopper_left", ..., as in `walls`.
        stress : "normal_stress_Pa" or "shear_stress_Pa".

        """
        rows = self.walls[(self.walls.state == state) & (self.walls.wall == wall)].dropna(subset=[stress])
        rows = rows.sort_values("height_m")
        return rows["height_m"].to_numpy(float), rows[stress].to_numpy(float)

    @cached_property
    def trouble(self) -> tuple[str, ...]:
        """A sentence for each file that a tolerant reader found damaged, and one if rows of the forces are lost."""
        for name in ("summary", "forces", "walls", "snapshots"):
            getattr(self, name)
        found, written = list(self._damaged), self.summary.get("records")
        if isinstance(written, int) and 0 < len(self.forces) < written:
            found.append(
                f"forces.csv has {len(self.forces)} of the {written} records of the run: rows are lost, and what is "
                "told of the end is of the last that is there."
            )
        ended = self.program.get("finished") is True and (self.folder / CHECKPOINT).exists()
        if ended and not self.summary:
            found.append(f"The run has ended; `{go_on(self.folder)}` writes summary.json once more.")
        return tuple(found)

    # states of the sand

    @cached_property
    def snapshots(self) -> pd.DataFrame:
        """Stored states that are there, by time, one for each time: file, stage, time_s, displacement_m."""
        table = self._table("snapshots/index.csv", SNAPSHOTS)
        inside = [file == Path(file).name and (self.folder / "snapshots" / file).is_file() for file in table["file"]]
        table = table[np.array(inside, bool)].sort_values("time_s", kind="stable")
        return table.drop_duplicates("time_s", keep="last").reset_index(drop=True)

    def need_states(self) -> "Result":
        """Return this run, if it is of a silo and has stored states, as films and exports need them; else BadInput."""
        self.scene  # noqa: B018 - which is read here, before any work
        if "filling" not in self.snapshots["stage"].to_list():
            of = "" if self.snapshots.empty else " of the filling"
            raise BadInput(f"folder {self.folder} has no snapshots{of}; it must be that of a run that has begun")
        return self

    def state(self, which: str | int = -1) -> dict[str, np.ndarray]:
        """All points of a stored state, as `Simulation.points` gives them.

        `position` (n, 2) [m], `velocity` (n, 2) [m/s], `void_ratio`, `stress` (xx, yy, zz, xy; tension positive) [Pa],
        `volume` [m2/m], `mass` [kg/m], `path` of the strain, `identity`.

        Parameters
        ----------
        which : the row of `snapshots`, from the end if negative, or the file's name without its suffix ("filled").

        Raises
        ------
        BadInput
            if there is no such state, or its file is damaged.

        """
        names = [Path(file).stem for file in self.snapshots.file]
        numbers = range(-len(names), len(names))
        if isinstance(which, bool) or which not in (names if isinstance(which, str) else numbers):
            named = [name for name in names if not name.startswith(snapshot.BETWEEN)]
            right = f"one of {', '.join(named)}, or its number in `snapshots`"
            raise BadInput(f"state is {shown(which)}; it must be {right}")
        name = which if isinstance(which, str) else names[which]
        return snapshot.read(self.folder / "snapshots" / f"{name}.vtu")

    @cached_property
    def start(self) -> dict[str, np.ndarray]:
        """The points of the fill before anything has happened to them."""
        return self.state(0)

    @cached_property
    def flow_states(self) -> np.ndarray:
        """Numbers of the rows of `snapshots` that belong to the flow."""
        return np.flatnonzero(self.snapshots["stage"] == "flow")

    @cached_property
    def flow_start_s(self) -> float:
        """Time of the last stored state of the filling: when it was over, or as far as it came."""
        return float(self.snapshots["time_s"][self.snapshots["stage"] == "filling"].iloc[-1])

    @property
    def end_s(self) -> float:
        """Time of the last stored state."""
        return float(self.snapshots["time_s"].iloc[-1])

    def progress(self, row) -> float:
        """Place of a row of `snapshots` or `forces` on the course: displacement [m], or where free time of flow [s]."""
        if row["stage"] != "flow":
            return 0.0
        return float(row["time_s"] - self.flow_start_s if self.free else row["displacement_m"])

    # pictures

    @property
    def film(self) -> Path | None:
        """The film of void ratio, if one was drawn."""
        file = self.folder / FILM
        return file if file.exists() else None

    @property
    def figures(self) -> dict[str, Path]:
        """Figures by their names."""
        return {file.stem: file for file in sorted((self.folder / "figures").glob("*.png"))}

    def _repr_html_(self) -> str:
        """In a notebook: the film, or else the force curves, and the numbers that matter."""
        known = {} if self.residual is None else self.residual[["P", "T", "N"]]
        numbers = ", ".join(f"{name} = {force / 1e3:.3f} kN/m" for name, force in known.items())
        said = f"<p><code>{self.folder}</code> {'at the end: ' + numbers if numbers else 'has not ended'}</p>"
        if self.film is not None:
            data = base64.b64encode(self.film.read_bytes()).decode()
            return f'{said}<video controls width="720" src="data:video/mp4;base64,{data}"></video>'
        if "forces" in self.figures:
            data = base64.b64encode(self.figures["forces"].read_bytes()).decode()
            return f'{said}<img width="720" alt="forces" src="data:image/png;base64,{data}">'
        return said

    def _table(self, name: str, columns: tuple[str, ...]) -> pd.DataFrame:
        """A CSV file of the run with at least these columns."""
        empty = pd.DataFrame({column: pd.Series(dtype=object if column in WORDS else float) for column in columns})
        return self._read(name, lambda file: _whole_rows(bounded_reading.frame(file), columns, file, empty), empty)

    def _read(self, name: str, reader: Callable, empty):
        """What a reader makes of a file; `empty` if it is not there, or damaged and this reader is tolerant."""
        file = self.folder / name
        if not file.exists():
            return empty
        try:
            return reader(file)
        except BadInput:
            if not self.tolerant:
                raise
            self._damaged.append(f"{file.name} is damaged and was left out.")
            return empty


def _whole_rows(table: pd.DataFrame, columns: tuple[str, ...], file: Path, empty: pd.DataFrame) -> pd.DataFrame:
    """A table of a run with numbers for numbers, less the rows that say not where they belong.

    The first three columns (of the snapshots all four) say that; without them the file is damaged. Numbers beyond
    `LARGEST`, words in place of numbers, and further columns that are missing read as nan.
    """
    if not len(table.columns):
        return empty
    where = list(columns if columns is SNAPSHOTS else columns[:3])
    if lacking := [name for name in where if name not in table]:
        raise BadInput(f"{file} has no column {lacking[0]}; it must be that of a run")
    table = table.reindex(columns=[*table.columns, *(name for name in columns if name not in table)])
    for name in table.columns.difference(WORDS):
        values = pd.to_numeric(table[name], errors="coerce").astype(float)
        table[name] = values.where(values.abs() < LARGEST)
    table = table.dropna(subset=where).reset_index(drop=True)
    return table.astype({name: str for name in WORDS if name in table})
