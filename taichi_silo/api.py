"""The functions of the Python interface."""

import os
from pathlib import Path

from pydantic import ValidationError

from taichi_silo.errors import BadInput
from taichi_silo.runs import film_states, session
from taichi_silo.runs.observers import REGISTERED, Observer
from taichi_silo.runs.observers.film_recorder import FilmEnds, FilmRecorder
from taichi_silo.runs.observers.progress import ProgressLine
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import free_name
from taichi_silo.scene.sands import sand as named_sand
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene, scene_of
from taichi_silo.show.run_end import draw_figures, draw_film
from taichi_silo.utils import plugin_files
from taichi_silo.utils.bounded_reading import place
from taichi_silo.utils.messages import shown
from taichi_silo.utils.schema import one_sentence

__all__ = ["named_sand", "read_scene", "resume", "run"]


def checked(scene: Scene | dict) -> Scene:
    """A scene as its types allow it, also one that was made by changing parts of another, which are then unchecked.

    Raises
    ------
    BadInput
        if it is not possible, or no scene.

    """
    if not isinstance(scene, Scene | dict):
        raise BadInput(f"scene is {shown(scene)}; it must be a Scene, or its tables")
    try:
        return scene_of(scene) if isinstance(scene, dict) else Scene.model_validate(scene.model_dump(warnings=False))
    except ValidationError as error:
        raise BadInput(one_sentence(error)) from error


DRAWING = (draw_film, draw_figures)  # at the end of a run


def _drawing(figures: bool) -> tuple[session.Draw, ...]:
    return tuple(draw for draw in DRAWING if figures or draw is not draw_figures)


def _observers(film: Observer, extra: tuple, progress: bool) -> tuple[Observer, ...]:
    """The observers beside those of every run: of the film, of plugins, those that were given, the progress line."""
    plugin_files.installed()
    for one in extra:
        if not isinstance(one, Observer):
            raise BadInput(f"extra is {shown(one)}; it must be observers, see taichi_silo.runs.observers.Observer")
    registered = (kind() for kind in REGISTERED.values())
    return (film, *registered, *extra, *((ProgressLine(),) if progress else ()))


def run(
    scene: Scene | dict,
    folder: str | os.PathLike | None = None,
    *,
    overwrite: bool = False,
    film: bool = True,
    figures: bool = True,
    progress: bool = True,
    extra: tuple = (),
) -> Result:
    """Run a scene and leave its folder.

    Parameters
    ----------
    scene : what to simulate, or its tables as a scene file has them.
    folder : where to leave it; the first free one of outputs/run, outputs/run-2, ... if not given.
    overwrite : replace a run that is there.
    film : draw the film.
    figures : draw the figures; `taichi-silo report` draws what is missing later.
    progress : say what it will cost, and how far it is.
    extra : further observers (`taichi_silo.runs.observers.Observer`).

    Returns
    -------
    What it left.

    Raises
    ------
    BadInput
        before any work, if the scene is not possible, or the folder or the processor cannot be used.
    RunFailed
        if the run went wrong; the folder then holds everything up to that time.
    Stopped
        if Ctrl-C or the signal to end asked for it; `resume` goes on from there.

    """
    scene = checked(scene)
    where = place(folder, "folder") if folder is not None else free_name(Path("outputs") / "run")
    states = where / film_states.NAME
    observers = _observers(FilmRecorder(states) if film else FilmEnds(states), extra, progress)
    return Result(session.run(scene, where, overwrite=overwrite, extra=observers, drawing=_drawing(figures)))


def resume(
    folder: str | os.PathLike,
    *,
    threads: int | None = None,
    film: bool | None = None,
    figures: bool = True,
    progress: bool = True,
    extra: tuple = (),
) -> Result:
    """Go on with a run that was left, however it ended; one that is finished stays as it is.

    Parameters
    ----------
    folder : of the run.
    threads : CPU threads; as many as before if not given.
    film : False draws no more of it; True or None go on with the film that was begun.
    figures : as in `run`.
    progress : say from where the run goes on, and how far it is.
    extra : further observers; each takes up what one of its kind kept.

    Returns
    -------
    What it left.

    Raises
    ------
    BadInput
        before any work, if there is nothing to go on from.
    RunFailed, Stopped
        as `run`.

    """
    where = place(folder, "folder")
    states = where / film_states.NAME
    recorder = FilmEnds(states) if film is False else FilmRecorder(states, wanted=film is True)
    observers = _observers(recorder, extra, progress)
    return Result(session.resume(where, threads=threads, extra=observers, drawing=_drawing(figures)))
