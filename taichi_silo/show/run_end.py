"""What is drawn when a run has ended. What cannot be drawn for want of a library or of ffmpeg costs only itself.

matplotlib and the encoder are imported when something is drawn: runs step without them.
"""

from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.runs import film_states
from taichi_silo.runs.result import FILM, Result
from taichi_silo.runs.run_folder import typed
from taichi_silo.show.film import FilmError


def draw_film(folder: Path) -> str | None:
    """Draw the film of a run that has kept states for it; returns a sentence if that is not possible."""
    if not (folder / film_states.NAME).exists():
        return None
    try:
        from taichi_silo.show.film import films, moments
        from taichi_silo.show.film.look import Look
        from taichi_silo.show.film.renderer import states_of

        history = Result(folder).need_states()
        states = states_of(history, "void_ratio")
        if states is not None:
            films.film(history, folder / FILM, moments.kept(history, states), Look())
        return None
    except (ImportError, FilmError, BadInput) as error:
        (folder / FILM).unlink(missing_ok=True)  # one of an earlier stop, which ends there
        return f"The film is not drawn, because {_why(error)}; `taichi-silo render {typed(folder)}` draws it later."


def draw_figures(folder: Path) -> str | None:
    """Draw the figures of a run; returns a sentence if that is not possible."""
    try:
        from taichi_silo.show.figures import plot_run

        plot_run(folder)
        return None
    except ImportError as error:
        return (
            f"The figures are not drawn, because {_why(error)}; `taichi-silo report {typed(folder)}` draws them later."
        )


def _why(error: Exception) -> str:
    return f"there is no {error.name}" if isinstance(error, ImportError) and error.name else str(error)
