"""Films and pictures of any field of a run, drawn from what the run has left, without disturbing it."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from taichi_silo.errors import BadInput
from taichi_silo.runs import film_states
from taichi_silo.runs.film_states import FilmStates
from taichi_silo.runs.point_fields import field as field_of
from taichi_silo.runs.result import Result
from taichi_silo.show.film import moments
from taichi_silo.show.film.between import Between
from taichi_silo.show.film.canvas import SIZE, Course
from taichi_silo.show.film.encoder import FRAMES_PER_SECOND, encode
from taichi_silo.show.film.moments import Moment
from taichi_silo.show.film.picture import Picture, course_of
from taichi_silo.utils import atomic_write

FEWEST_STATES = 10  # of flow: between fewer, straight lines would be invented motion
SAMPLED = 12  # states of the flow from which the range of colours follows
OF_FILM_STATES = ("void_ratio", "layers")  # fields for which the states of the film suffice; others take the snapshots


@dataclass(frozen=True)
class Look:
    """How a field is drawn.

    Attributes
    ----------
    field : its name.
    limits : values at the ends of the colours; from the scene and the data if absent.
    size : columns and rows.

    """

    field: str = "void_ratio"
    limits: tuple[float, float] | None = None
    size: tuple[int, int] = SIZE


class Renderer:
    """Draws one field of one run; Taichi has been started.

    Parameters
    ----------
    history : of the run.
    look : how the field is drawn.
    states : from which; the snapshots if absent.

    Raises
    ------
    BadInput
        if there is no such field, or a state cannot be read.

    """

    def __init__(self, history: Result, look: Look, states: FilmStates | None = None):
        self.history, field = history, field_of(look.field)

        def values(points: dict[str, np.ndarray]) -> np.ndarray:
            return field.values(points, history.start, history.scene)

        self.between = Between(states or history, values)
        rows = history.flow_states if len(history.flow_states) else np.arange(len(history.snapshots))
        sampled = np.unique(rows[np.linspace(0, len(rows) - 1, min(SAMPLED, len(rows))).round().astype(int)])
        found = [] if states else [values(history.state(number)) for number in sampled]
        self.scale = field.scaled(history.scene, np.concatenate([np.zeros(0), *found]), look.limits)
        self.picture = Picture(history.scene, self.scale, course(history), look.size)
        self.rows, self.told = list(history.forces.to_dict("records")), 0

    def frame(self, moment: Moment) -> np.ndarray:
        """The frame of a moment; moments must not run back."""
        while self.told < len(self.rows) and self.rows[self.told]["time_s"] <= moment.time_s * (1.0 + 1e-12):
            row = self.rows[self.told]
            self.picture.canvas.add_forces(self.history.progress(row), np.array([row["P"], row["T"], row["N"]]))
            self.told += 1
        return self.picture.frame(*self.between.at(moment.time_s), moment)


def states_of(history: Result, field: str) -> FilmStates | None:
    """The states that the run has kept for its film, if they suffice for a field; None: the snapshots are drawn."""
    file = history.folder / film_states.NAME
    states = FilmStates(file) if field in OF_FILM_STATES and file.exists() else None
    return states if states is not None and len(states.index) else None


def film(
    history: Result, file: Path, shown: Iterable[Moment], look: Look, frames_per_second: int = FRAMES_PER_SECOND
) -> Renderer:
    """Draw a film of such moments; it is there when it is complete, or not at all.

    Raises
    ------
    BadInput
        if the run has too few states.
    FilmError
        if it cannot be encoded.

    """
    states, many = states_of(history, look.field), len(history.flow_states)
    if states is None and (0 < many < FEWEST_STATES or len(history.snapshots) < 2):
        raise BadInput(
            f"snapshots of the flow are {many}; a film needs at least {FEWEST_STATES}: run it again with "
            "--snapshots 100, or draw single pictures with --frame"
        )
    renderer = Renderer(history, look, states)
    encode(file, map(renderer.frame, shown), frames_per_second)
    return renderer


def moments_of(history: Result, field: str, frames: int) -> list[Moment]:
    """What a film of so many frames shows: the very states that the run has kept, if it has kept as many."""
    states = states_of(history, field)
    if states is not None and states.index["shown"].sum() == frames:
        return moments.kept(history, states)
    return moments.over(history, frames)


def still(history: Result, file: Path, number: int, look: Look) -> Renderer:
    """Draw the picture of one snapshot, a row of the index; it is there when it is complete, or not at all."""
    renderer, row = Renderer(history, look), history.snapshots.iloc[number]
    moment = Moment(float(row["time_s"]), row["stage"], history.progress(row))
    with atomic_write.written(file) as passing:
        Image.fromarray(renderer.frame(moment)).save(passing, format="png")
    return renderer


def course(history: Result) -> Course:
    """That of the scene; free outflow as long as it has lasted."""
    found = course_of(history.scene)
    return found._replace(end=max(history.end_s - history.flow_start_s, 1e-9)) if history.free else found
