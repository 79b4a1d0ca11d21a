"""Keeps the states that the film of a run shows, while the run goes on."""

from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.runs import film_states
from taichi_silo.runs.observers import Observer
from taichi_silo.utils.appended_file import AppendedFile

FRAMES = {"filling": 45, "flow": 405}  # 15 s at 30 frames a second


class FilmEnds(Observer):
    """Takes away the states of a film with which a run does not go on.

    Parameters
    ----------
    file : where the states are.

    """

    def __init__(self, file: Path):
        self.file = file

    def restore(self, simulation, kept: dict) -> None:
        """Take them away."""
        self.file.unlink(missing_ok=True)


class FilmRecorder(Observer):
    """A state each time the bottom has moved, or the filling has taken, a fixed share of the whole.

    Parameters
    ----------
    file : where the states go.
    wanted : a run that goes on without its beginning filmed is refused; else it goes on without the film.

    """

    def __init__(self, file: Path, wanted: bool = False):
        self.file, self.wanted = file, wanted

    def joins(self, kept: dict | None) -> bool:
        """Only a run that was begun with it."""
        if kept is None and self.wanted:
            raise BadInput(
                f"film is asked for; the run in {self.file.parent} was begun without, and its beginning is gone"
            )
        return kept is not None

    def begin(self, simulation) -> None:
        """Begin the file."""
        self._look(simulation)
        self.shown = dict.fromkeys(FRAMES, 0)
        self.packing, self.states = film_states.Packing(), AppendedFile(self.file)
        self.states.append(self.head)

    def _look(self, simulation) -> None:
        self.simulation, flow = simulation, simulation.scene.flow
        self.head, self.units = film_states.head(simulation.scene.spacing_m)
        # the rest after the filling takes about ten periods; a longer one adds no frames
        self.filling_span = simulation.model.filling_time + 10.0 * simulation.model.period
        self.free, self.end_of_flow = flow.free, flow.displacement_m
        if self.free:
            self.end_of_flow = flow.longest_s

    def state(self) -> dict:
        """How many frames show the states so far, and the bytes of their file."""
        return {"shown": self.shown, "bytes": self.states.sync()}

    def restore(self, simulation, kept: dict) -> None:
        """Cut off what was written later, and go on after the last state."""
        self._look(simulation)
        self.shown, self.states = dict(kept["shown"]), AppendedFile(self.file, kept["bytes"])
        self.packing = film_states.FilmStates(self.file).last_packing()

    def observe(self, record) -> None:
        """Keep the state if a frame is due; a fast bottom is shown by several frames of one state."""
        frames = FRAMES[record.stage]
        due = min(frames, int(self._part(record) * frames + 1e-9)) - self.shown[record.stage]
        if due > 0:
            self.shown[record.stage] += due
            self.states.append(
                film_states.piece(
                    self.packing, self.units, self.simulation.points(*film_states.FIELDS), record.time_s, record.stage,
                    record.displacement_m, due,
                )
            )  # fmt: skip

    def _part(self, record) -> float:
        """Which part of the filling, or of the flow, is over."""
        if record.stage == "filling":
            return record.time_s / self.filling_span
        done = record.time_s - self.simulation.clock.flow_start if self.free else record.displacement_m
        return done / self.end_of_flow

    def end(self) -> None:
        """Close the file."""
        self.states.close()
