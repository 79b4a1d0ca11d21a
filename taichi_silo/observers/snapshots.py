"""Snapshots of the state of all points, which ParaView opens."""

import csv
from pathlib import Path

import meshio
import numpy as np

from taichi_silo import durable
from taichi_silo.observers import Observer

TOLERANCE = 1e-9  # of a displacement, in metres


class Snapshots(Observer):
    """`snapshots/*.vtu` at wanted bottom displacements, `snapshots/index.csv` and `silo.pvd` that list them.

    Parameters
    ----------
    folder : of the run.
    displacements_m : at which to write; the start, the end of filling and the end of the run are always written. Points
        that are not finite are left out.

    """

    def __init__(self, folder: Path, displacements_m):
        self.folder = folder / "snapshots"
        self.wanted = sorted(displacements_m)

    def begin(self, simulation) -> None:
        """Write the unstressed fill."""
        self.simulation = simulation
        self.folder.mkdir(exist_ok=True)
        for old in self.folder.glob("*.vtu"):
            old.unlink()
        self.rows = []
        self._write("start")

    def state(self) -> dict:
        """What is written, and what is still wanted."""
        return {"rows": self.rows, "wanted": self.wanted}

    def restore(self, simulation, kept: dict) -> None:
        """Take out what was written later."""
        self.simulation, self.rows, self.wanted = simulation, kept["rows"], kept["wanted"]
        known = {row["file"] for row in self.rows}
        for file in self.folder.glob("*.vtu"):
            if file.name not in known:
                file.unlink()
        self._list()

    def observe(self, record) -> None:
        """Write when a displacement is reached."""
        while record.stage == "flow" and self.wanted and record.displacement_m >= self.wanted[0] - TOLERANCE:
            self._write(f"flow_{1e3 * self.wanted.pop(0):07.3f}mm")

    def filled(self) -> None:
        """Write the state after filling."""
        self._write("filled")

    def end(self) -> None:
        """Write the last state."""
        if self.simulation.steps > 0 and self.rows[-1]["time_s"] != self.simulation.time:
            self._write("end")

    def _write(self, name: str) -> None:
        simulation = self.simulation
        points = simulation.points()
        sound = np.all([np.isfinite(values.reshape(len(values), -1)).all(axis=1) for values in points.values()], axis=0)
        points = {name: values[sound] for name, values in points.items()}
        count = len(points["mass"])
        place = np.column_stack([points["position"], np.zeros(count)])
        xx, yy, zz, xy = points["stress"].T
        data = {
            "void_ratio": points["void_ratio"],
            "velocity": np.column_stack([points["velocity"], np.zeros(count)]),
            "stress_Pa": np.column_stack([xx, yy, zz, xy]),
            "mean_stress_Pa": -(xx + yy + zz) / 3.0,
            "volume_m2_per_m": points["volume"],
            "mass_kg_per_m": points["mass"],
            "strain_path": points["path"],
            "identity": points["identity"],
        }
        mesh = meshio.Mesh(place, [("vertex", np.arange(count)[:, None])], point_data=data)
        file = self.folder / f"{name}.vtu"
        mesh.write(file, file_format="vtu")
        durable.sync(file)
        self.rows.append(
            {
                "file": file.name,
                "stage": simulation.stage,
                "time_s": simulation.time,
                "displacement_m": simulation.displacement,
            }
        )
        self._list()

    def _list(self) -> None:
        """Write both lists of what there is."""
        with open(self.folder / "index.csv", "w", newline="") as stream:
            writer = csv.DictWriter(stream, self.rows[0])
            writer.writeheader()
            writer.writerows(self.rows)
        entries = "".join(f'<DataSet timestep="{row["time_s"]:.6g}" file="{row["file"]}"/>\n' for row in self.rows)
        (self.folder / "silo.pvd").write_text(
            '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"><Collection>\n'
            f"{entries}</Collection></VTKFile>\n"
        )
