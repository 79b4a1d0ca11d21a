"""One run: a scene, its observers, and the folder they leave."""

import contextlib
import signal
import threading
import time
from pathlib import Path

from taichi_silo import folder as run_folder
from taichi_silo.observers import Observer
from taichi_silo.observers.checkpoint import Checkpoint
from taichi_silo.observers.forces import BALANCE, FORCES, Table
from taichi_silo.observers.guard import Guard
from taichi_silo.observers.movie import Movie
from taichi_silo.observers.profiles import WallProfiles
from taichi_silo.observers.snapshots import Snapshots
from taichi_silo.observers.summary import Summary
from taichi_silo.observers.watch import Watch
from taichi_silo.scene import Scene
from taichi_silo.simulation import Simulation

FIGURE_DISPLACEMENTS_M = (0.002, 0.005, 0.010, 0.020)  # of the paper's figure 12, after the state at 0
FIGURE_SHARES = (0.02, 0.1, 0.3)  # of the displacement of a free outflow


def run(scene: Scene, folder: Path, *, overwrite: bool = False, film: bool = True, extra: tuple = ()) -> Path:
    """Simulate a scene and leave its folder.

    Parameters
    ----------
    scene : what to simulate.
    folder : where to leave it.
    overwrite : replace a run that is there.
    film : whether to draw the film.
    extra : further observers.

    Returns
    -------
    The folder.

    Raises
    ------
    BadInput
        before any work, if the folder or the processor cannot be used.
    RunFailed
        if the run went wrong; the folder then holds everything up to that time.

    """
    scene.machine.start()
    folder = run_folder.claim(folder, overwrite)
    begun = time.time()
    simulation = Simulation(scene)
    profiles = WallProfiles(folder / "walls.csv")
    summary = Summary(folder / "summary.json", profiles)
    last = scene.flow.displacement_m
    free = scene.flow.outflow == "gravity"
    figured = [share * last for share in FIGURE_SHARES] if free else FIGURE_DISPLACEMENTS_M
    wanted = {u for u in figured if u < last}
    observers: list[Observer] = [
        Table(folder / "forces.csv", FORCES, bodies=True),
        Table(folder / "balance.csv", BALANCE),
        profiles,
        Snapshots(folder, wanted | {scene.flow.displacement_m}, scene.snapshots),
        Checkpoint(folder / "checkpoint.npz"),
        summary,
        *([Movie(folder / "void_ratio.mp4")] if film else []),
        Watch(),
        *extra,
        Guard(),  # last: the others have seen what it stops at
    ]
    started, failures = [], []
    try:
        with _interrupt_between_intervals() as check:
            for observer in observers:
                started.append(observer)
                observer.begin(simulation)
            run_folder.write_parameters(folder, scene, {"wall_seconds": 0.0})
            for record in simulation.fill():
                _show(observers, record)
                check()
            for observer in observers:
                observer.filled()
            for record in simulation.flow():
                _show(observers, record)
                check()
    except BaseException as error:
        summary.failure = str(error) or type(error).__name__
        raise
    finally:
        run_folder.write_parameters(folder, scene, {"wall_seconds": round(time.time() - begun, 3)})
        for end in (*(observer.end for observer in started), lambda: _draw(folder)):
            try:
                end()
            except Exception as error:  # noqa: BLE001 - one that cannot finish must not keep the others from it
                failures.append(error)
    if failures:
        raise failures[0]
    return folder


def _show(observers, record) -> None:
    for observer in observers:
        observer.observe(record)


@contextlib.contextmanager
def _interrupt_between_intervals():
    """Let Ctrl-C take effect between two intervals only, where clock and points agree."""
    asked = []

    def check() -> None:
        if asked:
            raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield check
        return
    usual = signal.signal(signal.SIGINT, lambda *_: asked.append(True))
    try:
        yield check
    finally:
        signal.signal(signal.SIGINT, usual)


def _draw(folder: Path) -> None:
    from taichi_silo.plots import plot_run  # matplotlib is slow to import, and only the end needs it

    plot_run(folder)
