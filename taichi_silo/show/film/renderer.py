"""Draws any field of a run, or of two beside each other, from what they have left, without disturbing them."""

from dataclasses import replace

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.runs import film_states
from taichi_silo.runs.film_states import FilmStates
from taichi_silo.runs.point_fields import Scale
from taichi_silo.runs.point_fields import field as field_of
from taichi_silo.runs.result import Result
from taichi_silo.show.film.between import Between, Way
from taichi_silo.show.film.curves import Course
from taichi_silo.show.film.force_rows import ForceRows
from taichi_silo.show.film.look import COLOURS, Look, view_of, whole
from taichi_silo.show.film.moments import Moment, sunk
from taichi_silo.show.film.picture import Picture, course_of, title

SAMPLED = 12  # states of the flow from which the range of colours follows
OF_FILM_STATES = ("void_ratio", "layers")  # fields for which the states of the film suffice; others take the snapshots


class Renderer:
    """Draws one field of one run; Taichi has been started.

    Parameters
    ----------
    history : of the run.
    look : how the field is drawn.
    states : from which; the snapshots if absent.
    course : what the curves are drawn against; that of the run if absent.
    **page : further parameters of `Picture`.

    Raises
    ------
    BadInput
        if there is no such field, or a state cannot be read, or the look does not suit the run.

    """

    def __init__(
        self, history: Result, look: Look, states: FilmStates | None = None, course: Course | None = None,
        scale: Scale | None = None, **page,
    ):  # fmt: skip
        self.history, self.field = history, field_of(look.field)
        silo = history.scene.silo
        way = None
        if silo.has_opening and silo.one_opening:
            way = Way(*silo.outlet_m, whole(history.scene).bottom - history.scene.spacing_m)
        self.between = Between(states or history, self._values, way)
        self.scale = scale or scale_of(history, look, states is not None)
        self.forces, self.told = ForceRows(history), 0
        self.course = course or course_over(history)
        self.by_time = course is not None
        page = {"largest_N_per_m": self.forces.largest} | page
        self.picture = Picture(history.scene, self.scale, self.course, look, note=self.forces.note, **page)

    def _values(self, points: dict[str, np.ndarray]) -> np.ndarray:
        return self.field.values(points, self.history.start, self.history.scene)

    def tell(self, moment: Moment) -> None:
        """Extend the curves up to a moment; moments must not run back."""
        forces, spread = self.forces, self.forces.spread
        while self.told < len(forces.times) and forces.times[self.told] <= moment.time_s * (1.0 + 1e-12):
            k = self.told
            self.picture.canvas.add_forces(self._place(k), forces.forces[k], None if spread is None else spread[k])
            self.told += 1

    def _place(self, row: int) -> float:
        """Place of a row of the forces on the course."""
        if self.by_time:
            return max(0.0, float(self.forces.times[row]) - self.history.flow_start_s)
        return self.history.progress(self.forces.rows[row])

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of a frame."""
        return self.picture.canvas.layout.size

    def frame(self, moment: Moment) -> np.ndarray:
        """The frame of a moment; moments must not run back."""
        self.tell(moment)
        return self.picture.frame(*self.between.at(moment.time_s), moment)


def scale_of(history: Result, look: Look, of_film: bool) -> Scale:
    """The colours of a field of a run.

    Raises
    ------
    BadInput
        if colours are asked for that there are not, or for classes, which have their own.

    """
    field = field_of(look.field)
    if look.colours is not None and (look.colours not in COLOURS or isinstance(field.scale.colours, tuple)):
        right = f"it must be one of {', '.join(COLOURS)}"
        if look.colours in COLOURS:
            right = f"the classes of {look.field} have colours of their own, and it must be left out"
        raise BadInput(f"colours is {look.colours}; {right}")
    rows = history.flow_states if len(history.flow_states) else np.arange(len(history.snapshots))
    sampled = np.unique(rows[np.linspace(0, len(rows) - 1, min(SAMPLED, len(rows))).round().astype(int)])
    states = [] if of_film else [history.state(number) for number in sampled]
    found = [field.values(points, history.start, history.scene) for points in states]
    return look.coloured(field.scaled(history.scene, np.concatenate([np.zeros(0), *found]), look.limits))


def states_of(history: Result, field: str) -> FilmStates | None:
    """The states that the run has kept for its film, if they suffice for a field; None: the snapshots are drawn."""
    file = history.folder / film_states.NAME
    states = FilmStates(file) if field in OF_FILM_STATES and file.exists() else None
    return states if states is not None and len(states.index) else None


def course_over(history: Result) -> Course:
    """What the curves of a run are drawn against; free outflow as long as it has lasted."""
    found = course_of(history.scene)
    return found._replace(end=max(history.end_s - history.flow_start_s, 1e-9)) if history.free else found


class Pair:
    """Draws two runs beside each other with one clock: the time since the flow began, and one scale of everything.

    Parameters
    ----------
    histories : of the runs.
    look : how both are drawn; its size is that of the whole.
    from_film : whether to draw from the states of their films, where both have them.

    """

    def __init__(self, histories: tuple[Result, Result], look: Look, from_film: bool = True):
        self.histories = histories
        states = [states_of(history, look.field) if from_film else None for history in histories]
        if None in states:
            states = [None, None]
        scales = [scale_of(history, look, states[0] is not None) for history in histories]
        low, high = min(scale.low for scale in scales), max(scale.high for scale in scales)
        scale = replace(scales[0], low=low, high=high, decades=low > 0.0 and any(one.decades for one in scales))
        end = max(max(history.end_s - history.flow_start_s for history in histories), 1e-9)
        course = Course(end, "time since the flow began (s)", "flows since", "s", 1.0)
        self.stacked, self.half = halves(look)
        weight = max(history.scene.weight_N_per_m for history in histories)
        largest = max(ForceRows(history).largest for history in histories)
        views = [view_of(history.scene, look) for history in histories]
        at_most = min(look.page(view, size=self.half).pixels_per_metre for view in views)
        self.sides = [
            Renderer(
                history,
                replace(look, title=words),
                kept,
                course,
                scale,
                size=self.half,
                weight_N_per_m=weight,
                at_most=at_most,
                largest_N_per_m=largest,
            )
            for history, kept, words in zip(histories, states, _titles(histories, look), strict=True)
        ]
        self.scale = scale

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of a frame."""
        return (self.half[0], 2 * self.half[1]) if self.stacked else (2 * self.half[0], self.half[1])

    def frame(self, moment: Moment) -> np.ndarray:
        """The frame of a moment, whose time and progress are counted from where the flow began."""
        found = []
        for side in self.sides:
            start, end = side.history.flow_start_s, side.history.end_s
            own = min(max(start + moment.time_s, 0.0), end)
            stage = "flow" if own > start else "filling"
            found.append(side.frame(Moment(own, stage, max(0.0, own - start), sunk(side.history, own), moment.time_s)))
        return np.concatenate(found, axis=0 if self.stacked else 1)


def halves(look: Look) -> tuple[bool, tuple[int, int]]:
    """Whether two pages are stacked on one of the look's size, and the size of each."""
    wide, high = look.page_size
    stacked = high > wide
    return stacked, ((wide, high // 2) if stacked else (wide // 2, high))


def _titles(histories: tuple[Result, Result], look: Look) -> list[str | None]:
    """Titles of two runs: that of one's own, or each run's, with its folder where they are alike."""
    words = [title(history.scene) for history in histories]
    if look.title is not None or words[0] != words[1]:
        return [look.title, look.title]
    return [f"{history.folder.resolve().name}: {one}" for history, one in zip(histories, words, strict=True)]
