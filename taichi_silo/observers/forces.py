"""Wall-force histories: `forces.csv`, and `balance.csv` with what closes the balance of each of its rows."""

import csv
from pathlib import Path

from taichi_silo.observers import Observer

FORCES = {
    "time_s": lambda r: r.time_s,
    "stage": lambda r: r.stage,
    "displacement_m": lambda r: r.displacement_m,
    "bottom_force_N_per_m": lambda r: r.bottom_N_per_m,
    "left_normal_N_per_m": lambda r: r.left_normal_N_per_m,
    "left_shear_N_per_m": lambda r: r.left_shear_N_per_m,
    "right_normal_N_per_m": lambda r: r.right_normal_N_per_m,
    "right_shear_N_per_m": lambda r: r.right_shear_N_per_m,
    "wall_friction_angle_deg": lambda r: r.wall_friction_angle_deg,
    "weight_N_per_m": lambda r: r.weight_N_per_m,
    "discharged_kg_per_m": lambda r: r.discharged_kg_per_m,
    "kinetic_energy_J_per_m": lambda r: r.kinetic_energy_J_per_m,
}
# bottom + shears = weight + momentum_rate - control (+ residual), in every row
BALANCE = {
    "time_s": lambda r: r.time_s,
    "stage": lambda r: r.stage,
    "momentum_rate_N_per_m": lambda r: r.momentum_rate_N_per_m,
    "noise_control_force_N_per_m": lambda r: r.control_N_per_m,
    "residual_N_per_m": lambda r: r.residual_N_per_m,
    "time_step_s": lambda r: r.time_step_s,
    "stable_step_s": lambda r: r.stable_step_s,
}


def of_bodies(names) -> dict:
    """Columns of hopper walls and inserts: force on the sand to the right, and upwards."""
    axes = ("horizontal", "vertical")
    return {
        f"{name}_{axis}_N_per_m": lambda r, name=name, k=k: r.bodies_N_per_m[name][k]
        for name in names
        for k, axis in enumerate(axes)
    }


class Table(Observer):
    """One row of a CSV file for each record; on disk as soon as it is known.

    Parameters
    ----------
    file : where to.
    columns : name and function of a record.
    bodies : whether columns of hopper walls and inserts follow.

    """

    def __init__(self, file: Path, columns: dict, bodies: bool = False):
        self.file, self.columns, self.bodies = file, columns, bodies

    def begin(self, simulation) -> None:
        """Write the head."""
        if self.bodies:
            self.columns = self.columns | of_bodies(simulation.bodies)
        self.stream = open(self.file, "w", newline="", buffering=1)  # noqa: SIM115 - closed in end()
        self.writer = csv.writer(self.stream)
        self.writer.writerow(self.columns)

    def observe(self, record) -> None:
        """Write a row, with digits enough to check the balance to 1e-9."""
        values = (read(record) for read in self.columns.values())
        self.writer.writerow(value if isinstance(value, str) else f"{value:.13g}" for value in values)

    def end(self) -> None:
        """Close the file."""
        self.stream.close()
