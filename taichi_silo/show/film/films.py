"""Films and pictures of runs as files, each there when it is complete, or not at all."""

from collections.abc import Iterable
from pathlib import Path

from PIL import Image

from taichi_silo.errors import BadInput, Way
from taichi_silo.runs.result import Result
from taichi_silo.show.film import moments
from taichi_silo.show.film.encoder import FRAMES_PER_SECOND, encode
from taichi_silo.show.film.look import Look
from taichi_silo.show.film.moments import Moment
from taichi_silo.show.film.renderer import Pair, Renderer, states_of
from taichi_silo.show.film.sequence import write_sequence
from taichi_silo.show.film.vector import write_svg
from taichi_silo.utils import atomic_write

FEWEST_STATES = 10  # of flow: between fewer, straight lines would be invented motion


def film(
    history: Result, file: Path, shown: Iterable[Moment], look: Look, frames_per_second: int = FRAMES_PER_SECOND,
    other: Result | None = None,
) -> Renderer | Pair:  # fmt: skip
    """Draw a film of such moments; a name without an ending is a folder of pictures.

    Parameters
    ----------
    history : of the run.
    file : that becomes the film.
    shown : what the frames show; of two runs with their one clock (`moments.together`).
    look : how it is drawn.
    frames_per_second : of the film.
    other : a run beside it.

    Raises
    ------
    BadInput
        if a run has too few states.
    FilmError
        if it cannot be encoded.

    """
    runs = [history] if other is None else [history, other]
    states = {id(run): states_of(run, look.field) for run in runs}
    kept = all(found is not None for found in states.values())
    for run in runs:
        many = len(run.flow_states)
        if not kept and (0 < many < FEWEST_STATES or len(run.snapshots) < 2):
            more, one = Way("output.snapshots = 100", "--snapshots 100"), Way("frame=...", "--frame")
            words = f"snapshots of the flow are {many}; a film needs at least {FEWEST_STATES}: run it again with "
            raise BadInput(words + f"{more}, or draw single pictures with {one}", more, one)
    renderer: Renderer | Pair
    renderer = Renderer(history, look, states[id(history)]) if other is None else Pair((history, other), look)
    frames = map(renderer.frame, shown)
    if file.suffix:
        encode(file, frames, frames_per_second)
    else:
        write_sequence(file, frames)
    return renderer


def moments_of(history: Result, field: str, frames: int) -> list[Moment]:
    """What a film of so many frames shows: the very states that the run has kept, if it has kept as many."""
    states = states_of(history, field)
    if states is not None and states.index["shown"].sum() == frames:
        return moments.kept(history, states)
    return moments.over(history, frames)


def still(history: Result, file: Path, number: int, look: Look) -> Renderer:
    """Draw the picture of one snapshot, a row of the index, as PNG or SVG."""
    renderer, row = Renderer(history, look), history.snapshots.iloc[number]
    moment = Moment(float(row["time_s"]), row["stage"], history.progress(row))
    with atomic_write.written(file) as passing:
        if file.suffix.lower() == ".svg":
            write_svg(renderer, moment, passing)
        else:
            Image.fromarray(renderer.frame(moment)).save(passing, format="png")
    return renderer


def still_of_two(histories: tuple[Result, Result], file: Path, since_s: float, look: Look) -> Pair:
    """Draw the picture of two runs so long after their flows began, as PNG."""
    pair = Pair(histories, look, from_film=False)
    with atomic_write.written(file) as passing:
        frame = pair.frame(Moment(since_s, "flow" if since_s > 0.0 else "filling", max(since_s, 0.0)))
        Image.fromarray(frame).save(passing, format="png")
    return pair
