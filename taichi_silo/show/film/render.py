"""Draw a film or a picture of a run, or of two beside each other, afterwards."""

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from taichi_silo.errors import BadInput, MachineFailed
from taichi_silo.mpm import runtime
from taichi_silo.runs.point_fields import Scale
from taichi_silo.runs.point_fields import field as field_of
from taichi_silo.runs.result import Result
from taichi_silo.scene.scene import cores
from taichi_silo.show.film import FilmError, asked, films, moments
from taichi_silo.show.film.look import Look, view_of
from taichi_silo.show.film.moments import Moment, Slow
from taichi_silo.show.film.renderer import scale_of
from taichi_silo.utils.bounded_reading import as_left, place
from taichi_silo.utils.machine_faults import of_file

SECONDS = 15.0  # of a film, if neither a length nor a speed is given


class Drawn(NamedTuple):
    """What was drawn.

    Attributes
    ----------
    file : the film, the picture, or the folder of pictures.
    size : columns and rows.
    scale : of the colours.
    frames, seconds : of a film.
    snapshot : that a picture shows.

    """

    file: Path
    size: tuple[int, int]
    scale: Scale
    frames: int = 1
    seconds: float = 0.0
    snapshot: str = ""


def render(
    run: Result | str | os.PathLike,
    file: str | os.PathLike | None = None,
    *,
    field: str = "void_ratio",
    limits: tuple[float, float] | None = None,
    colours: str | None = None,
    layout: str | None = None,
    size: tuple[int, int] | None = None,
    axes: bool = True,
    zoom_mm: tuple[float, float, float, float] | None = None,
    title: str | None = None,
    transparent: bool = False,
    beside: Result | str | os.PathLike | None = None,
    seconds: float | None = None,
    speed: float | None = None,
    slow: tuple[float, float, float] | None = None,
    fps: int | None = None,
    frame: float | None = None,
    overwrite: bool = False,
    tracked: Callable[[list[Moment]], Iterable[Moment]] = iter,
) -> Drawn:
    """Draw a film of any field of a run, or one picture, from the states that it has kept; Taichi is started anew.

    Parameters
    ----------
    run : the run, or its folder.
    file : .mp4, .webm, .gif, a folder of PNG (no ending), or with `frame` .png or .svg; in the run's folder if absent.
    field : one of `taichi_silo.runs.point_fields.FIELDS`.
    limits : ends of the colours; from the scene and the data if absent.
    colours : "viridis", "cividis", "plasma", "inferno", "magma", "gray", "coolwarm", "PuOr" or "BrBG".
    layout : "16:9", "9:16", "1:1" or "sand".
    size : columns and rows, even.
    axes : whether the sand has axes.
    zoom_mm : left, bottom, right and top of what is seen.
    title : in place of sand, walls and silo.
    transparent : pictures whose background is see-through.
    beside : a second run, or its folder, with the same clock: the time since the flow began.
    seconds : length of the film.
    speed : of the sand over its own, in place of a length.
    slow : (from, to, times): a part of the flow, in mm of displacement, that is shown so many times more slowly; in
        free outflow, or with `beside`, in s.
    fps : frames a second.
    frame : one picture, at this displacement in mm; in free outflow, or with `beside`, so many seconds after the begin.
    overwrite : replace what is there.
    tracked : what the moments are passed through as they are drawn, such as a progress bar.

    Returns
    -------
    What was drawn; its `file` is the path.

    Raises
    ------
    BadInput
        before any work, if that is not possible.
    RunFailed
        if it could not be drawn.

    """
    field_of(field)
    asked.need_length(seconds, speed, fps, frame)
    asked.need_limits(limits)
    asked.need_box(zoom_mm)
    asked.need_look(layout, size, colours, title, axes)
    runs = [_run(one) for one in ((run,) if beside is None else (run, beside))]
    by_time = beside is not None or runs[0].free
    slowly = asked.slow_of(slow, 1.0 if by_time else 1e-3)
    if frame is not None and slowly is not None:
        raise BadInput(f"slow is {','.join(f'{x:g}' for x in slow or ())}; one picture has no slow part")
    look = Look(field, limits, size, layout, axes, colours, zoom_mm, title, transparent)
    with as_left(runs[0].folder):
        _drawable(runs, look)
        wanted = Path(file) if file is not None else runs[0].folder / _name(field, frame, by_time, transparent)
        asked.need_kind(wanted, frame, transparent, beside is not None)
        if frame is None:
            every = asked.rate(fps, wanted)
            shown = moments_of(runs, field, seconds, speed, slowly, every)
        number = moments.nearest(runs[0], frame * (1.0 if by_time else 1e-3)) if frame is not None and not beside else 0
    wanted = asked.free(wanted, overwrite)
    runtime.init("cpu", min(2, cores()))
    try:
        with as_left(runs[0].folder):
            if frame is None:
                drawn = films.film(runs[0], wanted, tracked(shown), look, every, *runs[1:])
                return Drawn(wanted, drawn.size, drawn.scale, len(shown), len(shown) / every)
            if beside is not None:
                pair = films.still_of_two((runs[0], runs[1]), wanted, frame, look)
                return Drawn(wanted, pair.size, pair.scale)
            drawn = films.still(runs[0], wanted, number, look)
            return Drawn(wanted, drawn.size, drawn.scale, snapshot=str(runs[0].snapshots["file"].iloc[number]))
    except OSError as error:
        raise of_file(error, wanted) from error
    except FilmError as error:
        raise MachineFailed(f"{wanted} could not be drawn: {error}; see to that, and give the command again") from error


def _run(run: Result | str | os.PathLike) -> Result:
    return (run if isinstance(run, Result) else Result(place(run, "folder"))).need_states()


def _drawable(runs: list[Result], look: Look) -> None:
    """Check what hangs on the runs."""
    for run in runs:
        view_of(run.scene, look)
    if look.colours is not None:
        scale_of(runs[0], look, of_film=True)


def _name(field: str, frame: float | None, by_time: bool, transparent: bool) -> str:
    """The name of what is drawn, if none is given."""
    if frame is not None:
        return f"{field}_{frame:g}{'s' if by_time else 'mm'}.png"
    return f"{field}_frames" if transparent else f"{field}.mp4"


def moments_of(
    runs: list[Result], field: str, seconds: float | None, speed: float | None, slow: Slow | None, fps: int
) -> list[Moment]:
    """What the frames show."""
    frames = max(2, round((seconds or SECONDS) * fps))
    if speed is not None:
        lasts = max(run.end_s for run in runs) / speed
        if lasts > asked.LONGEST_S:
            raise BadInput(f"speed is {speed:g}; the film would last {lasts:.4g} s, it must be at most 600 s")
    if len(runs) == 2:
        both = runs[0], runs[1]
        shown = moments.together_at_speed(both, speed, fps) if speed else moments.together(both, frames)
    elif speed is not None:
        shown = moments.at_speed(runs[0], speed, fps)
    else:
        shown = films.moments_of(runs[0], field, frames)
    if slow is not None:
        shown = moments.slowed(shown, slow)
        if len(shown) > asked.LONGEST_S * fps:
            raise BadInput(
                f"slow is {slow.times:g} times; the film would last {len(shown) / fps:.4g} s, it must be at most "
                f"{asked.LONGEST_S:g} s"
            )
    return shown
