"""The functions of the Python interface."""

import os
from pathlib import Path

from taichi_silo import one_run
from taichi_silo.folder import free_name
from taichi_silo.observers.progress import ProgressLine
from taichi_silo.result import Result
from taichi_silo.sands import sand as named_sand
from taichi_silo.scene import Scene
from taichi_silo.scene_file import read_scene

__all__ = ["named_sand", "read_scene", "run"]


def run(
    scene: Scene,
    folder: str | os.PathLike | None = None,
    *,
    overwrite: bool = False,
    film: bool = True,
    progress: bool = True,
    extra: tuple = (),
) -> Result:
    """Run a scene and leave its folder.

    Parameters
    ----------
    scene : what to simulate.
    folder : where to leave it; the first free one of outputs/run, outputs/run-2, ... if not given.
    overwrite : replace a run that is there.
    film : draw the film.
    progress : say what it will cost, and how far it is.
    extra : further observers (`taichi_silo.observers.Observer`).

    Returns
    -------
    What it left.

    Raises
    ------
    BadInput
        before any work, if the folder or the processor cannot be used.
    RunFailed
        if the run went wrong; the folder then holds everything up to that time.

    """
    where = Path(folder) if folder is not None else free_name(Path("outputs") / "run")
    lines = (ProgressLine(),) if progress else ()
    return Result(one_run.run(scene, where, overwrite=overwrite, film=film, extra=(*extra, *lines)))
