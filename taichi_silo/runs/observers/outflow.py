"""What leaves by each of several outlets: `outflow.csv`."""

from pathlib import Path

from taichi_silo.runs.observers.forces import Table


def columns_of(number: int) -> tuple[str, str, str, str]:
    """Columns of outlet `number`: speed of its gate over that of an open one, mass, rate, force on the gate."""
    outlet = f"outlet_{number}"
    return f"{outlet}_open", f"{outlet}_kg_per_m", f"{outlet}_kg_per_s_m", f"{outlet}_gate_N_per_m"


class Outflow(Table):
    """One row for each record, of a scene with more than one opening in the floor that opens with the outflow."""

    def __init__(self, file: Path, outlets: int):
        self.before = [0.0] * outlets
        of_outlets = tuple(name for number in range(outlets) for name in columns_of(number + 1))
        super().__init__(file, ("time_s", "stage", "displacement_m", *of_outlets))

    def state(self) -> dict:
        """How many bytes are written, and what had left by then."""
        return super().state() | {"before": self.before}

    def restore(self, simulation, kept: dict) -> None:
        """Cut off what was written later."""
        super().restore(simulation, kept)
        self.before = list(kept["before"])

    def observe(self, record) -> None:
        """Write a row; the rate is the mean over its interval."""
        cells: list[str | float] = [record.time_s, record.stage, record.displacement_m]
        each = zip(record.gates, record.outlets_kg_per_m, self.before, record.gates_N_per_m, strict=True)
        for share, mass, before, force in each:
            cells += [share, mass, (mass - before) / record.interval_s, force]
        self.before = list(record.outlets_kg_per_m)
        self._write(value if isinstance(value, str) else f"{value:.13g}" for value in cells)
