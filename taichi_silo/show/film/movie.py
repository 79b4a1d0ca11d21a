"""The film of a run: `void_ratio.mp4`."""

import functools
from pathlib import Path

import numpy as np

from taichi_silo.runs.observers import Observer
from taichi_silo.runs.observers.forces import rows_of
from taichi_silo.runs.point_fields import FIELDS
from taichi_silo.show.film.encoder import FilmError, program
from taichi_silo.show.film.film import Film
from taichi_silo.show.film.scenery import course_of, picture

FLOW_FRAMES, FILLING_FRAMES = 405, 45  # 15 s


def outlived(method):
    """What goes wrong with the film ends the film, and not the run."""

    @functools.wraps(method)
    def call(self, *given):
        try:
            return method(self, *given)
        except (FilmError, OSError) as error:
            return self.lose(error)

    return call


class Movie(Observer):
    """A frame each time the bottom has moved, or the filling has taken, a fixed share of the whole.

    A run whose film cannot be drawn any more goes on without, with a warning; what was drawn is kept.
    """

    def __init__(self, file: Path):
        self.file, self.lost = file, False
        self.kept_until = None  # time of the last frame in a finished piece [s]

    def begin(self, simulation) -> None:
        """Open the film."""
        self._open(simulation)
        self._find_ffmpeg()

    def _open(self, simulation) -> None:
        self.simulation, scene = simulation, simulation.scene
        settling = 10.0 * simulation.period  # an estimate; a longer rest adds no frames
        self.filling_span = simulation.filling_time + settling
        self.drawn = {"filling": 0, "flow": 0}
        self.course = course_of(scene)
        self.film = Film(self.file, picture(scene, FIELDS["void_ratio"].scaled(scene, np.zeros(0))))

    @outlived
    def _find_ffmpeg(self) -> None:
        program()

    def state(self) -> dict:
        """How many frames are drawn, the pieces of film that hold them, and whether it goes on."""
        self._cut()
        pieces = [piece.name for piece in self.film.segments.pieces]
        return {"drawn": self.drawn, "pieces": pieces, "lost": self.lost, "kept_until": self.kept_until}

    @outlived
    def _cut(self) -> None:
        if not self.lost and self.film.segments.cut():
            self.kept_until = self.simulation.time

    def restore(self, simulation, kept: dict) -> None:
        """Draw the curves once more, from the rows that are written, and go on after the pieces."""
        self._open(simulation)
        self.drawn, self.lost, self.kept_until = kept["drawn"], kept["lost"], kept["kept_until"]
        for row in rows_of(self.file.parent).itertuples():
            self._extend(row)
        self.film.segments.go_on(kept["pieces"])

    @outlived
    def observe(self, record) -> None:
        """Extend the curves, and draw when a frame is due."""
        if self.lost:
            return
        progress = self._extend(record)
        flowing = record.stage == "flow"
        frames = FLOW_FRAMES if flowing else FILLING_FRAMES
        part = progress / self.course.end if flowing else record.time_s / self.filling_span
        due = min(frames, int(part * frames + 1e-9))
        if due > self.drawn[record.stage]:
            points = self.simulation.points()
            for _ in range(due - self.drawn[record.stage]):  # a fast bottom: frames repeat, the film keeps its length
                self.film.add_frame(
                    points["position"], points["void_ratio"], time_s=record.time_s, stage=record.stage,
                    displacement_m=progress,
                )  # fmt: skip
            self.drawn[record.stage] = due

    def _extend(self, record) -> float:
        """Extend the curves to a record; returns its place on the course."""
        progress = self._progress(record)
        self.film.add_forces(progress, record.bottom_N_per_m, record.shear_N_per_m, record.normal_N_per_m)
        return progress

    def _progress(self, record) -> float:
        """Place on the course: the displacement, or of free outflow the time since the gate opened."""
        if self.simulation.scene.flow.outflow == "gravity":
            return record.time_s - self.simulation.flow_start if record.stage == "flow" else 0.0
        return record.displacement_m

    def end(self) -> None:
        """Join the film, also a short one; its pieces stay, for a run that goes on."""
        self._cut()
        self._join()

    @outlived
    def _join(self) -> None:
        self.film.segments.close(keep=True)

    def lose(self, error: Exception) -> None:
        """Draw no more of it, and say why."""
        self.film.segments.abandon()
        if self.lost:
            return
        self.lost = True
        there = f"The film ends at t = {self.kept_until:.4f} s" if self.film.segments.pieces else "There is no film"
        why = f"{error.filename}: {error.strerror}" if isinstance(error, OSError) and error.filename else error
        cure = ""
        if self.simulation.scene.snapshots:
            cure = f"; `taichi-silo render {self.file.parent} --overwrite` draws it from the snapshots"
        self.simulation.warnings.append(f"{there}, because {why}{cure}.")

    @property
    def fate(self) -> str:
        """What became of it: "ended early", or "whole" if it is as far as the run."""
        return "ended early" if self.lost else "whole"
