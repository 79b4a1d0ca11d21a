"""One run: a scene, its observers, and the folder they leave; and the same run, gone on with after it was left."""

from pathlib import Path

from taichi_silo.errors import BadInput, MachineFailed, Stopped
from taichi_silo.runs import run_folder as run_folder
from taichi_silo.runs.observers import Observer, checkpoint
from taichi_silo.runs.observers.checkpoint import Checkpoint
from taichi_silo.runs.observers.forces import BALANCE, FORCES, Table
from taichi_silo.runs.observers.guard import Guard
from taichi_silo.runs.observers.log import Log
from taichi_silo.runs.observers.snapshots import Snapshots
from taichi_silo.runs.observers.summary import Summary
from taichi_silo.runs.observers.wall_profiles import WallProfiles
from taichi_silo.scene import memory_need
from taichi_silo.scene.scene import Scene
from taichi_silo.show.film.movie import Movie
from taichi_silo.show.film.segments import clear
from taichi_silo.simulation import restart
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.utils import bounded_reading, checked_npz, file_lock
from taichi_silo.utils.machine_faults import of_machine
from taichi_silo.utils.signals import Stops, heard

FIGURE_DISPLACEMENTS_M = (0.002, 0.005, 0.010, 0.020)  # of the paper's figure 12, after the state at 0
FIGURE_SHARES = (0.02, 0.1, 0.3)  # of the displacement of a free outflow
BEFORE = "stopped before the run had begun; there is nothing of it to go on from"
STILL = "stopped before the run went on; nothing has changed, and `%s` goes on with it"
DRAWING = "stopped while the figures were drawn; all else is there, and `%s` draws them"


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
        before any work, if the folder or the processor cannot be used, or the memory does not suffice.
    RunFailed
        if the run went wrong; the folder then holds everything up to that time.
    Stopped
        if Ctrl-C or the signal to end asked for it; `resume` goes on from there.

    """
    with heard() as stops:
        with stops.at_once(BEFORE):
            memory_need.check(scene)
            scene.machine.start()
            folder = run_folder.free(folder, overwrite)
        with file_lock.held(folder):
            with stops.at_once(BEFORE):
                session = _Session(scene, run_folder.free(folder, overwrite), film, extra)
            run_folder.claim(folder, overwrite)
            session.go(stops)
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
    folder = bounded_reading.place(folder, "folder")
    if run_folder.finished(folder):
        clear(folder)  # what a death between the last two lines of a run leaves
        return folder
    if not checkpoint.is_there(folder):
        what = "holds no checkpoint to go on from" if folder.is_dir() else "does not exist"
        raise BadInput(f"folder is {folder}; it must be that of a run that was begun, but it {what}")
    with heard() as stops, file_lock.held(run_folder.own(folder)):
        with stops.at_once(STILL % run_folder.go_on(folder)):
            with checked_npz.understood(folder):
                kept, words = checkpoint.latest(folder)
                checked_npz.need(kept, "run.filled", "run.resumed", "run.wall_seconds", "observers.forces",
                             "simulation.points", "simulation.clock.time")  # fmt: skip
                scene, drawn = checkpoint.scene_of(kept, threads), "film" in kept["observers"]
            run_folder.same_scene(folder, scene)
            if film and not drawn:
                raise BadInput(f"film is asked for; the run in {folder} was begun without, and its beginning is gone")
            memory_need.check(scene)
            scene.machine.start()
            session = _Session(scene, folder, drawn if film is None else film, extra, kept, words)
        session.go(stops)
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
            with checked_npz.understood(folder):
                restart.restore(self.simulation, kept["simulation"])
        self.simulation.warnings += words
        last, free = scene.flow.displacement_m, scene.flow.outflow == "gravity"
        figured = [share * last for share in FIGURE_SHARES] if free else FIGURE_DISPLACEMENTS_M
        profiles = WallProfiles(folder / "walls.csv")
        self.summary = Summary(folder / "summary.json", profiles)
        self.log = Log(folder / "run.log")
        self.film = Movie(folder / "void_ratio.mp4") if film else None
        self.observers: dict[str, Observer] = {
            "forces": Table(folder / "forces.csv", FORCES, bodies=True),
            "balance": Table(folder / "balance.csv", BALANCE),
            "profiles": profiles,
            "snapshots": Snapshots(folder, {u for u in figured if u < last} | {last}, scene.snapshots),
            **({"film": self.film} if self.film else {}),
            "summary": self.summary,  # after those whose warnings it tells
            **{f"{type(one).__name__}_{number}": one for number, one in enumerate(extra)},
            "guard": Guard(),  # after the others: they have seen what it stops at
            "log": self.log,
        }
        self.checkpoint = Checkpoint(folder, self.observers, kept["run"] if kept else None)

    def go(self, stops: Stops) -> None:
        """Begin, or go on, and leave everything that a run leaves."""
        begun, ended = [], None
        try:
            self._work(begun, stops)
        except BaseException as error:  # noqa: BLE001 - whatever ends it, its files are put in order first
            ended = self._in_words(error)
            self.summary.failure = self.log.failure = str(ended) or type(ended).__name__
        troubles = self._end(begun, stops)
        if self.folder.is_dir():
            try:
                self._note(finished=ended is None and not troubles)
            except OSError as error:
                troubles.append(error)
        if ended is not None or troubles:
            raise ended or self._in_words(troubles[0])
        clear(self.folder)

    def _work(self, begun: list, stops: Stops) -> None:
        """All that may go wrong midway; `begun` gathers the observers that have begun."""
        for name, observer in (self.observers | {"checkpoint": self.checkpoint}).items():
            begun.append(observer)
            self._begin(name, observer)
        self._note()
        self._simulate(begun, stops.check)

    def _end(self, begun: list, stops: Stops) -> list:
        """End all observers, and draw; what went wrong."""
        troubles = []
        for observer in begun:
            try:
                observer.end()
            except Exception as error:  # noqa: BLE001 - one that cannot finish must not keep the others from it
                troubles.append(error)
        if self.folder.is_dir():
            try:
                with stops.at_once(DRAWING % run_folder.go_on(self.folder)):
                    self._draw()
            except (Exception, Stopped) as error:  # noqa: BLE001 - as above
                troubles.append(error)
        return troubles

    def _in_words(self, error: BaseException) -> BaseException:
        """The error; of the machine, one that says when, what, and what to do."""
        if of_machine(error) is None:
            return error
        what, remedy = of_machine(error)
        further = f"`{run_folder.go_on(self.folder)}` goes on from its last checkpoint"
        if not self.folder.is_dir():
            what = f"the folder {self.folder} was gone, and {what}"
            further = "`taichi-silo resume` goes on; if it was removed, begin again"
        elif not checkpoint.is_there(self.folder):
            further = "begin again"
        failed = MachineFailed(f"stopped at {self._when()} because {what}; {remedy}, then {further}")
        failed.__cause__ = error
        return failed

    def _begin(self, name: str, observer: Observer) -> None:
        if self.kept is None:
            observer.begin(self.simulation)
        else:
            with checked_npz.understood(self.folder):
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

    def _when(self) -> str:
        s = self.simulation
        return f"t = {s.time:.4f} s ({s.stage}, u = {1e3 * s.displacement:.3f} mm)"

    def _farewell(self) -> str:
        return f"stopped at {self._when()}; `{run_folder.go_on(self.folder)}` goes on from there"

    def _note(self, finished: bool = False) -> None:
        """Write run.toml."""
        done = {"wall_seconds": round(self.checkpoint.wall_seconds, 3), "finished": finished}
        done |= {"resumed": self.checkpoint.resumed, "film": self.film.fate if self.film else "none"}
        run_folder.write_parameters(self.folder, self.simulation.scene, done)

    def _draw(self) -> None:
        from taichi_silo.show.figures import plot_run  # matplotlib is slow to import, and only the end needs it

        plot_run(self.folder)
