"""Wall-force histories: `forces.csv`, and `balance.csv` with what closes the balance of each of its rows."""

import csv
import io
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.runs.observers import Observer
from taichi_silo.utils.appended_file import AppendedFile

FORCES = (
    "time_s", "stage", "displacement_m", "bottom_force_N_per_m", "left_normal_N_per_m", "left_shear_N_per_m",
    "right_normal_N_per_m", "right_shear_N_per_m", "wall_friction_angle_deg", "weight_N_per_m", "discharged_kg_per_m",
    "kinetic_energy_J_per_m",
)  # fmt: skip
# bottom + shears = weight + momentum_rate - control (+ residual), in every row
BALANCE = (
    "time_s", "stage", "momentum_rate_N_per_m", "noise_control_force_N_per_m", "residual_N_per_m", "time_step_s",
    "stable_step_s",
)  # fmt: skip


class Table(Observer):
    """One row of a CSV file for each record; in the file as soon as it is known, as a whole or not at all.

    Parameters
    ----------
    file : where to.
    columns : of a record.
    bodies : whether the forces on the sand of hopper walls and inserts follow, to the right and upwards.

    """

    def __init__(self, file: Path, columns: tuple[str, ...], bodies: bool = False):
        self.file, self.columns, self.bodies = file, columns, bodies

    def begin(self, simulation) -> None:
        """Write the head."""
        names = simulation.model.wall_forces.bodies if self.bodies else ()
        further = [f"{name}_{axis}_N_per_m" for name in names for axis in ("horizontal", "vertical")]
        self.rows = AppendedFile(self.file)
        self._write([*self.columns, *further])

    def _write(self, cells) -> None:
        row = io.StringIO(newline="")
        csv.writer(row).writerow(cells)
        self.rows.append(row.getvalue().encode())

    def state(self) -> dict:
        """How many bytes are written."""
        return {"bytes": self.rows.sync()}

    def restore(self, simulation, kept: dict) -> None:
        """Cut off what was written later."""
        self.rows = AppendedFile(self.file, kept["bytes"])

    def observe(self, record) -> None:
        """Write a row, with digits enough to check the balance to 1e-9."""
        values = [getattr(record, name) for name in self.columns]
        if self.bodies:
            values += [component for force in record.bodies_N_per_m.values() for component in force]
        self._write(value if isinstance(value, str) else f"{value:.13g}" for value in values)

    def end(self) -> None:
        """Close the file."""
        self.rows.close()


def rows_of(folder: Path) -> pd.DataFrame:
    """All records that the files of a run hold, with N, T and the length of the interval.

    A row that one of the files lacks, as when a disk was full, is left out.
    """
    folder = folder.absolute()  # pandas reads a relative "file:x/..." as an address
    forces, balance = (pd.read_csv(folder / name, encoding="utf-8") for name in ("forces.csv", "balance.csv"))
    count = min(len(forces), len(balance))
    rest = balance.columns.difference(forces.columns)
    found = pd.concat([forces[:count], balance.loc[: count - 1, rest]], axis=1)
    for name in ("normal", "shear"):
        found[f"{name}_N_per_m"] = 0.5 * (found[f"left_{name}_N_per_m"] + found[f"right_{name}_N_per_m"])
    return found.assign(interval_s=np.diff(found["time_s"], prepend=0.0))
