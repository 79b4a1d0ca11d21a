"""Films and pictures of any field of a run, drawn from what the run has left, without disturbing it."""

import contextlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from taichi_silo.errors import BadInput
from taichi_silo.mpm import runtime
from taichi_silo.runs.point_fields import field as field_of
from taichi_silo.runs.result import Result
from taichi_silo.scene.scene import cores
from taichi_silo.show.film.between import Between
from taichi_silo.show.film.canvas import SIZE, Course
from taichi_silo.show.film.encoder import Encoder
from taichi_silo.show.film.film import FRAMES_PER_SECOND
from taichi_silo.show.film.moments import Moment
from taichi_silo.show.film.scenery import course_of, picture

FEWEST_STATES = 10  # of flow: between fewer, straight lines would be invented motion
SAMPLED = 12  # states of the flow from which the range of colours follows


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
    """Draws one field of one run; starts Taichi.

    Raises
    ------
    BadInput
        if there is no such field, or a snapshot cannot be read.

    """

    def __init__(self, history: Result, look: Look):
        self.history, field = history, field_of(look.field)
        self.between = Between(history, field)
        rows = history.flow_states if len(history.flow_states) else np.arange(len(history.snapshots))
        sampled = np.unique(rows[np.linspace(0, len(rows) - 1, min(SAMPLED, len(rows))).round().astype(int)])
        values = np.concatenate([self.between.values(history.state(number)) for number in sampled])
        self.scale = field.scaled(history.scene, values, look.limits)
        runtime.init("cpu", min(2, cores()))
        self.picture = picture(history.scene, self.scale, look.size, course(history))
        self.rows, self.told = list(history.forces.to_dict("records")), 0

    def frame(self, moment: Moment) -> dict:
        """What `Picture.frame` needs; moments must not run back."""
        while self.told < len(self.rows) and self.rows[self.told]["time_s"] <= moment.time_s + 1e-12:
            row = self.rows[self.told]
            self.picture.add_forces(self.history.progress(row), row["P"], row["T"], row["N"])
            self.told += 1
        position, values = self.between.at(moment.time_s)
        when = {"time_s": moment.time_s, "stage": moment.stage, "displacement_m": moment.progress}
        return {"position": position, "values": values} | when


def film(
    history: Result, file: Path, moments: Iterable[Moment], look: Look, frames_per_second: int = FRAMES_PER_SECOND
) -> Renderer:
    """Draw a film of such moments; it is there when it is complete, or not at all.

    Raises
    ------
    BadInput
        if the run has too few snapshots.

    """
    many = len(history.flow_states)
    if 0 < many < FEWEST_STATES or len(history.snapshots) < 2:
        raise BadInput(
            f"snapshots of the flow are {many}; a film needs at least {FEWEST_STATES}: run it again with "
            "--snapshots 100, or draw single pictures with --frame"
        )
    renderer = Renderer(history, look)
    encoder = Encoder(file.with_name(f"{file.stem}.rendering{file.suffix}"), frames_per_second, look.size)
    try:
        for moment in moments:
            encoder.write(renderer.picture.frame(**renderer.frame(moment)))
        encoder.close()
        encoder.path.replace(file)
    finally:
        with contextlib.suppress(RuntimeError):  # what has ended the film is on its way already
            encoder.close()
        for left in (encoder.path, encoder.partial):
            left.unlink(missing_ok=True)
    return renderer


def still(history: Result, file: Path, number: int, look: Look) -> Renderer:
    """Draw the picture of one state, a row of the index; it is there when it is complete, or not at all."""
    renderer, row = Renderer(history, look), history.snapshots.iloc[number]
    moment = Moment(float(row["time_s"]), row["stage"], history.progress(row))
    drawn = Image.fromarray(renderer.picture.frame(**renderer.frame(moment)))
    passing = file.with_name(f"{file.name}.part")
    drawn.save(passing, format="png")
    passing.replace(file)
    return renderer


def course(history: Result) -> Course:
    """That of the scene; free outflow as long as it has lasted."""
    found = course_of(history.scene)
    return found._replace(end=max(history.end_s - history.flow_start_s, 1e-9)) if history.free else found
