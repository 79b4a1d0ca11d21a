"""One run: a scene, its observers, and the folder they leave; and the same run, gone on with after it was left."""

from pathlib import Path

from taichi_silo import archive, lock, reading, state
from taichi_silo import folder as run_folder
from taichi_silo.faults import BadInput, Stopped
from taichi_silo.observers import Observer, checkpoint
from taichi_silo.observers.checkpoint import Checkpoint
from taichi_silo.observers.forces import BALANCE, FORCES, Table
from taichi_silo.observers.guard import Guard
from taichi_silo.observers.movie import Movie
from taichi_silo.observers.profiles import WallProfiles
from taichi_silo.observers.segments import clear
from taichi_silo.observers.snapshots import Snapshots
from taichi_silo.observers.summary import Summary
from taichi_silo.observers.watch import Watch
from taichi_silo.scene import Scene
from taichi_silo.simulation import Simulation
from taichi_silo.stopping import between_intervals

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
    Stopped
        if Ctrl-C or the signal to end asked for it; `resume` goes on from there.

    """
    scene.machine.start()
    folder = run_folder.free(folder, overwrite)
    with lock.held(folder):
        run_folder.claim(folder, overwrite)
        _Session(scene, folder, film, extra).go()
    return folder


def resume(folder: Path, *, threads: int | None = None, film: bool | None = None, extra: tuple = ()) -> Path:
    """Go on with a run that was left, however it ended; one that is finished stays as it is.

    On the same machine and as many threads it becomes, bit by bit, what it would have become without the break.

    Parameters
    ----------
    folder : of the run.
    threads : CPU threads; as many as before if not given.
    film : False draws no more of it; True or None go on with the film that was begun.
    extra : further observers; each takes up what one of its kind kept.

    Returns
    -------
    The folder.

    Raises
    ------
    BadInput
        before any work, if there is nothing to go on from.
    RunFailed, Stopped
        as `run`.

    """
    folder = reading.place(folder, "folder")
    if run_folder.finished(folder):
        return folder
    if not checkpoint.is_there(folder):
        what = "holds no checkpoint to go on from" if folder.is_dir() else "does not exist"
        raise BadInput(f"folder is {folder}; it must be that of a run that was begun, but it {what}")
    with lock.held(run_folder.own(folder)):
        with archive.understood(folder):
            kept, words = checkpoint.latest(folder)
            archive.need(kept, "run.filled", "run.resumed", "run.wall_seconds", "observers.forces", "simulation.points",
                         "simulation.clock.time")  # fmt: skip
            scene, drawn = checkpoint.scene_of(kept, threads), "film" in kept["observers"]
        run_folder.same_scene(folder, scene)
        if film and not drawn:
            raise BadInput(f"film is asked for; the run in {folder} was begun without, and its beginning is gone")
        scene.machine.start()
        _Session(scene, folder, drawn if film is None else film, extra, kept, words).go()
    return folder


class _Session:
    """The part of a run that one process does.

    Parameters
    ----------
    scene, folder, film, extra : see `run`.
    kept : what a checkpoint holds, if the run goes on from one.
    words : warnings that belong to it.

    """

    def __init__(self, scene: Scene, folder: Path, film: bool, extra: tuple, kept: dict | None = None, words=()):
        self.folder, self.kept = folder, kept
        self.simulation = Simulation(scene)
        if kept:
            with archive.understood(folder):
                state.restore(self.simulation, kept["simulation"])
        self.simulation.warnings += words
        last, free = scene.flow.displacement_m, scene.flow.outflow == "gravity"
        figured = [share * last for share in FIGURE_SHARES] if free else FIGURE_DISPLACEMENTS_M
        profiles = WallProfiles(folder / "walls.csv")
        self.summary = Summary(folder / "summary.json", profiles)
        self.observers: dict[str, Observer] = {
            "forces": Table(folder / "forces.csv", FORCES, bodies=True),
            "balance": Table(folder / "balance.csv", BALANCE),
            "profiles": profiles,
            "snapshots": Snapshots(folder, {u for u in figured if u < last} | {last}, scene.snapshots),
            "summary": self.summary,
            **({"film": Movie(folder / "void_ratio.mp4")} if film else {}),
            "watch": Watch(),
            **{f"{type(one).__name__}_{number}": one for number, one in enumerate(extra)},
            "guard": Guard(),  # after the others: they have seen what it stops at
        }
        self.checkpoint = Checkpoint(folder, self.observers, kept["run"] if kept else None)

    def go(self) -> None:
        """Begin, or go on, and leave everything that a run leaves."""
        begun, failures = {}, []
        try:
            with between_intervals() as check:
                for name, observer in (self.observers | {"checkpoint": self.checkpoint}).items():
                    begun[name] = observer
                    self._begin(name, observer)
                self._note()
                self._simulate(begun.values(), check)
        except BaseException as error:
            self.summary.failure = str(error) or type(error).__name__
            raise
        finally:
            for end in (*(observer.end for observer in begun.values()), self._draw):
                try:
                    end()
                except Exception as error:  # noqa: BLE001 - one that cannot finish must not keep the others from it
                    failures.append(error)
            self._note(finished=self.summary.failure is None and not failures)
        if failures:
            raise failures[0]
        clear(self.folder)

    def _begin(self, name: str, observer: Observer) -> None:
        if self.kept is None:
            observer.begin(self.simulation)
        else:
            with archive.understood(self.folder):
                observer.restore(self.simulation, self.kept["observers"].get(name, {}))

    def _simulate(self, observers, check) -> None:
        """Fill and flow, as far as that is not done yet."""

        def show(record) -> None:
            for observer in observers:
                observer.observe(record)
            check(self._farewell)

        try:
            for record in self.simulation.fill():
                show(record)
            if not self.checkpoint.after_filling:
                for observer in observers:
                    observer.filled()
            for record in self.simulation.flow():
                show(record)
        except Stopped:
            self.checkpoint.write()
            raise
        self.checkpoint.write()

    def _farewell(self) -> str:
        s = self.simulation
        where = f"t = {s.time:.4f} s ({s.stage}, u = {1e3 * s.displacement:.3f} mm)"
        return f"stopped at {where}; `{run_folder.go_on(self.folder)}` goes on from there"

    def _note(self, finished: bool = False) -> None:
        """Write run.toml."""
        done = {"wall_seconds": round(self.checkpoint.wall_seconds, 3), "finished": finished}
        run_folder.write_parameters(self.folder, self.simulation.scene, done | {"resumed": self.checkpoint.resumed})

    def _draw(self) -> None:
        from taichi_silo.plots import plot_run  # matplotlib is slow to import, and only the end needs it

        plot_run(self.folder)
