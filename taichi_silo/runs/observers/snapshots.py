"""Snapshots of the state of all points, which ParaView opens, and from which films are drawn afterwards."""

import csv
import time
from pathlib import Path

from taichi_silo.runs import snapshot
from taichi_silo.runs.observers import Observer
from taichi_silo.utils import atomic_write

TOLERANCE = 1e-9  # of a displacement, in metres
LIST_EVERY_S = 1.0  # at most so often lists are written, and with each checkpoint and at the end
OF_FILLING = 0.1  # as many of the filling as of the flow, times this


class Snapshots(Observer):
    """`snapshots/*.vtu`, and `snapshots/index.csv` and `silo.pvd` that list them.

    They are brought to the disk with the next checkpoint: a run that goes on from one writes what came later anew.

    Parameters
    ----------
    folder : of the run.
    displacements_m : at which to write; the start, the end of filling and the end of the run are always written. Points
        that are not finite are left out.
    between : how many more to write evenly over the flow, and a tenth as many over the filling; their names begin
        with `film_`. Even is: in displacement, and where sand falls freely also in time, at most as many of each.

    """

    def __init__(self, folder: Path, displacements_m, between: int = 0):
        self.folder, self.between = folder / "snapshots", between
        self.wanted = sorted(displacements_m)
        self.unsynced: set[Path] = set()
        self.listed, self.listed_at = True, 0.0  # whether the lists hold all rows, and when they were written

    def begin(self, simulation) -> None:
        """Write the unstressed fill."""
        self.simulation = simulation
        self.folder.mkdir(exist_ok=True)
        for old in self.folder.glob("*.vtu"):
            old.unlink()
        self.rows: list[dict] = []
        self.due = {"filling": 0, "flow": 0}
        self._write("start")

    def state(self) -> dict:
        """What is written, and what is still wanted."""
        self._sync()
        return {"rows": self.rows, "wanted": self.wanted, "due": self.due}

    def restore(self, simulation, kept: dict) -> None:
        """Take out what was written later: of the list first, so that whatever is listed is there."""
        self.simulation = simulation
        self.rows, self.wanted, self.due = kept["rows"], kept["wanted"], kept["due"]
        self._list()
        known = {row["file"] for row in self.rows}
        for file in self.folder.glob("*.vtu"):
            if file.name not in known:
                file.unlink()

    def observe(self, record) -> None:
        """Write when a displacement is reached, or a share of the filling or the flow is over."""
        due = self._due(record)
        passed, self.due[record.stage] = due > self.due[record.stage], due
        while record.stage == "flow" and self.wanted and record.displacement_m >= self.wanted[0] - TOLERANCE:
            self._write(f"flow_{1e3 * self.wanted.pop(0):07.3f}mm")
            passed = False
        if passed:
            self._write(f"{snapshot.BETWEEN}{len(self.rows):05d}")
        if not self.listed and time.monotonic() - self.listed_at > LIST_EVERY_S:
            self._list()

    def _due(self, record) -> int:
        """How many shares of its stage are over."""
        simulation = self.simulation
        if record.stage == "filling":
            return int(OF_FILLING * self.between * min(record.time_s / simulation.model.filling_time, 1.0) + TOLERANCE)
        flow = simulation.scene.flow
        shares = [record.displacement_m / flow.displacement_m]
        if flow.free:
            shares.append((record.time_s - simulation.clock.flow_start) / flow.longest_s)
        return sum(int(self.between * share + TOLERANCE) for share in shares)

    def filled(self) -> None:
        """Write the state after filling."""
        self._write("filled")

    def end(self) -> None:
        """Write the last state."""
        named = [row for row in self.rows if not row["file"].startswith(snapshot.BETWEEN)]
        try:
            if self.simulation.clock.steps > 0 and named[-1]["time_s"] != self.simulation.time:
                self._write("end")
        finally:
            self._sync()

    def _sync(self) -> None:
        if not self.listed:
            self._list()
        for file in self.unsynced:
            atomic_write.sync(file)
        atomic_write.sync(self.folder)
        self.unsynced.clear()

    def _write(self, name: str) -> None:
        simulation = self.simulation
        file = self.folder / f"{name}.vtu"
        snapshot.write_pieces(file, simulation.names_of_points, simulation.pieces, synced=False)
        self.unsynced.add(file)
        self.rows.append(
            {
                "file": file.name,
                "stage": simulation.stage,
                "time_s": simulation.time,
                "displacement_m": simulation.displacement,
            }
        )
        self.listed = False

    def _list(self) -> None:
        """Write both lists of what there is."""
        self.listed, self.listed_at = True, time.monotonic()
        index, collection = self.folder / "index.csv", self.folder / "silo.pvd"
        self.unsynced |= {index, collection}
        with (
            atomic_write.written(index, synced=False) as passing,
            open(passing, "w", newline="", encoding="utf-8") as stream,
        ):
            writer = csv.DictWriter(stream, self.rows[0])
            writer.writeheader()
            writer.writerows(self.rows)
        entries = "".join(f'<DataSet timestep="{row["time_s"]:.9g}" file="{row["file"]}"/>\n' for row in self.rows)
        with atomic_write.written(collection, synced=False) as passing:
            passing.write_text(
                '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"><Collection>\n'
                f"{entries}</Collection></VTKFile>\n",
                encoding="utf-8",
            )
