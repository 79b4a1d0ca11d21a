"""Looks for wrongness all the time, says when, where, why and what to do, and stops a run that is lost."""

from pathlib import Path

from taichi_silo.runs.alarms import of_points as of_points
from taichi_silo.runs.alarms import of_records as of_records
from taichi_silo.runs.observers import Observer

EVERY_PERIODS = 10  # of the column, between two looks at all points
OF_RECORDS = (
    of_records.TimeStep, of_records.Speed, of_records.Density, of_records.Separation, of_records.Balance,
    of_records.Energy, of_records.Motion,
)  # fmt: skip
FIELDS = ("position", "void_ratio", "stress", "mass", "path", "identity")  # of the points, that these look at
OF_POINTS = (of_points.Outside, of_points.Ratcheting, of_points.Inertia)


class Guard(Observer):
    """Runs all checks; what they find is in `simulation.alarms`, and what does not stop the run in its warnings, too.

    Parameters
    ----------
    folder : of the run, on whose disk earlier states wait; where temporary files are if None.

    Raises
    ------
    RunFailed
        from `observe`, naming time, place, likely cause and remedy.

    """

    def __init__(self, folder: Path | None = None):
        self.folder = folder

    def begin(self, simulation) -> None:
        """Make the checks."""
        self.simulation, self.count = simulation, 0
        self.of_records = [check(simulation) for check in OF_RECORDS]
        self.of_points = [check(simulation, self.folder) for check in OF_POINTS]

    def state(self) -> dict:
        """Of all checks."""
        checks = {type(check).__name__: check.state() for check in (*self.of_records, *self.of_points)}
        return {"count": self.count, "checks": checks}

    def restore(self, simulation, kept: dict) -> None:
        """As they were."""
        self.begin(simulation)
        self.count = kept.get("count", 0)
        for check in (*self.of_records, *self.of_points):
            check.restore(kept.get("checks", {}).get(type(check).__name__, {}))

    def filled(self) -> None:
        """Show the checks of points the state that the flow starts from."""
        points = self.simulation.points(*of_points.Ratcheting.KEPT)
        for check in self.of_points:
            check.filled(points)

    def observe(self, record) -> None:
        """Run the checks of records, and now and then those of points."""
        for check in self.of_records:
            self._take(check.look(record))
        self.count += 1
        if self.count % (EVERY_PERIODS * self.simulation.scene.output.records_per_period):
            return
        points = self.simulation.points(*FIELDS)
        if len(points["mass"]):
            for one in self.of_points:
                self._take(one.look(record, points))

    def _take(self, alarm) -> None:
        simulation = self.simulation
        if alarm is not None and simulation.alarms.enter(alarm, simulation.clock):
            sentence = simulation.alarms.found[alarm.name].sentence
            simulation.warnings.append(f"{sentence[:1].upper()}{sentence[1:]}.")
